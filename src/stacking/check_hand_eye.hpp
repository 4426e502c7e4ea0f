#pragma once
#include <optional>
#include <string>

#include "hardware/cell_config.hpp"
#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/hardware/cell_file.hpp"

/// Private to stacking/: the hand-eye calibration of a cell file, compared with what the camera sees.
namespace stonestack::stacking {

/// Result of a check that found nothing wrong.
struct Found {
  std::string text;
  bool to_do = false;  ///< something to know or to do before a run
};

/// Arm and camera of a cell that stands still.
struct CellView {
  std::optional<Joints> q;          ///< of an arm that answers
  std::optional<DepthImage> image;  ///< taken now: not of a recording
};

/// Judges the hand-eye calibration by the table in the view, or by its numbers alone where no table is seen.
/// @throws DeviceError with what is wrong and what to do
[[nodiscard]] Found check_hand_eye(const CellConfig& cell, const CellView& view);

}  // namespace stonestack::stacking
