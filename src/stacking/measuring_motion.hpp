#pragma once
#include <string>

#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/motion/pick_and_place.hpp"
#include "stonestack/stacking/world_estimate.hpp"

/// Private to stacking/: what measurements that move the arm share.
namespace stonestack::stacking {

/// Options of motions that measure: the tool is never faster than 0.25 m/s, as in a cell's first run.
[[nodiscard]] MotionOptions measuring_motion();

/// The arm has ended a motion otherwise than asked.
/// @throws Error (safety stop) where it cannot move, DeviceError otherwise
[[noreturn]] void report_stop(Cell& cell, const std::string& reason);

/// Follows a route and takes a frame at its end, once the arm has settled.
/// @throws as `report_stop`
[[nodiscard]] CameraView view_after(Cell& cell, const RobotModel& robot, const JointTrajectory& route);

/// Scene of the empty gripper, with bodies where nothing is known yet: over the field and at the site.
[[nodiscard]] PlanningScene unknown_scene(const Cell& cell, const RobotModel& robot);

/// Backs away from what the gripper is near, and views the field.
/// @param scene   of `unknown_scene`
/// @throws DeviceError for a view that cannot be reached, and as `report_stop`
[[nodiscard]] CameraView view_unknown_field(Cell& cell, const RobotModel& robot, const PlanningScene& scene,
                                            const MotionOptions& options);

/// Result of `work`. Whatever it throws, the arm is stopped first.
template <class Work>
auto stopping_on_failure(Cell& cell, const Work& work) {
  try {
    return work();
  } catch (...) {
    try {
      cell.arm.stop();
    } catch (const Error& problem) {  // what ended the work is reported by the caller
      log_warning(problem.what());
    }
    throw;
  }
}

}  // namespace stonestack::stacking
