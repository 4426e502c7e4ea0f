#pragma once
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/motion/pick_and_place.hpp"

namespace stonestack {

/// What a timed motion must respect.
struct TimingLimits {
  Joints velocity;          ///< rad/s
  Joints acceleration;      ///< rad/s^2
  double blend = 0.005;     ///< rad (length of the joint vector) by which a corner may be cut; 0: stop there.
                            ///< 0.005 moves the tip by at most 8 mm, less than the transit padding
  double tool_speed = 0.0;  ///< m/s of T's origin; 0: no limit
};
/// Joint limits of the robot, scaled and bounded as the options say; no tool speed limit.
[[nodiscard]] TimingLimits timing_limits(const RobotModel& robot, const MotionOptions& options);

/// Times a path: it starts and ends at rest, corners are cut by parabolas within `limits.blend`, and the
/// rounded path is run as fast as the limits allow (phase plane with exact collocation on the parabolas,
/// Pham and Pham 2018; trapezoids on the lines). No knot interval exceeds a limit. A path without length
/// gives one knot. Throws InvalidArgument for an empty path, numbers that are not finite or limits that are
/// not positive. `limits.tool_speed` must be 0.
[[nodiscard]] JointTrajectory time_path(const JointPath& path, const TimingLimits& limits);
/// The same, and the tool (T_F_T on the flange) is never faster than `limits.tool_speed`.
[[nodiscard]] JointTrajectory time_path(const JointPath& path, const TimingLimits& limits,
                                        const RobotModel& robot, const Pose& T_F_T);

/// Points on the rounded path that `time_path` would follow, neighbours at most `step` rad apart (length of
/// the joint vector): what a collision check has to certify when `blend` is larger than the padding allows.
[[nodiscard]] JointPath rounded(const JointPath& path, double blend, double step);

}  // namespace stonestack
