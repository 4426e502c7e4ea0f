#pragma once
#include <functional>

#include "hardware/ur/joint_reader.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/report/record_run.hpp"

/// Private to report/: a recording of devices, wherever they are from.
namespace stonestack::report {

/// Devices that a recording reads. No other device is opened.
struct WatchedCell {
  DepthCamera& camera;
  std::function<JointReading()> joints;  ///< empty: no arm is asked
  const Clock& clock;
  std::function<void(double seconds)> wait;  ///< lets time pass; none if negative
  RobotModel robot;
};

/// Takes the frames of `order` into the folder of `record`, which names cell, camera and layout. Throws as
/// `record_views`.
[[nodiscard]] RecordedViews record_cell(const ViewsOrder& order, const WatchedCell& cell,
                                        RecordedViews record);

}  // namespace stonestack::report
