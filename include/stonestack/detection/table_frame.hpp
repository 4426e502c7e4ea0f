#pragma once
#include <optional>
#include <vector>

#include "stonestack/detection/detect_stones.hpp"

#pragma GCC visibility push(default)

namespace stonestack::detection {

/// The table in one depth image, in C with the normal towards the camera: the plane that `detect_stones` will
/// report, found in a small part of the time.
/// @return empty where the image shows no plane with little below it.
[[nodiscard]] std::optional<Plane> find_table(const DepthImage& image, const DetectionOptions& options = {});

/// T_W_C of a camera whose pose is unknown, by the table that it sees: the table is z = 0 of W with z up, the
/// point of the table below the camera is the origin, and x of W runs along the image's x.
[[nodiscard]] Pose camera_over(const Plane& table_C);

/// Which part of the table (z = 0 of W) a view shows, in square cells.
struct TableView {
  double cell = 0.02;                    ///< side of a cell [m]
  std::vector<Eigen::Vector2d> p_W;      ///< centres of the cells in which the bare table is seen, sorted
  Eigen::Vector2d p_W_middle{0.0, 0.0};  ///< of the box around them
  std::vector<Eigen::Vector3d> above_W;  ///< surface 1 cm and more above the table, one point a cube of 5 mm
};
/// Cells count where a depth lies within 4 mm of the plane.
[[nodiscard]] TableView view_of_table(const DepthImage& image, const Plane& table_C, const Pose& T_W_C,
                                      const DetectionOptions& options = {});

}  // namespace stonestack::detection

#pragma GCC visibility pop
