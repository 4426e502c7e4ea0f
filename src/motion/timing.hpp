#pragma once
#include <functional>

#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/motion/pick_and_place.hpp"

namespace stonestack::motion {

/// Limits of a timed motion.
struct TimingLimits {
  Joints velocity;       ///< [rad/s]
  Joints acceleration;   ///< [rad/s^2]
  double blend = 0.005;  ///< [rad] (length of the joint vector) by which a corner may be cut; 0: stop there.
                         ///< 0.005 moves the tip by at most 8 mm, less than the transit padding
  double jerk = 0.0;     ///< rad/s^3, of every joint; 0: no limit
  double tool_speed = 0.0;  ///< speed [m/s] of T's origin; 0: no limit
};
/// Largest speed (m/s, positive) of T's origin where the joints are at q.
using ToolSpeed = std::function<double(const Joints& q)>;

/// Joint limits of the robot, scaled and bounded by the options; no tool speed limit. Throws
/// InvalidArgument for a jerk limit so small that motions would not end in any reasonable time.
[[nodiscard]] TimingLimits timing_limits(const RobotModel& robot, const MotionOptions& options);

/// Times a path: it starts and ends at rest, corners are cut by parabolas within `limits.blend`, and the
/// rounded path is run as fast as the limits allow (phase plane with exact collocation on the parabolas,
/// Pham and Pham 2018; trapezoids on the lines). No knot interval exceeds a limit. A path without length
/// gives one knot.
///
/// With `limits.jerk` corners are cut by curves of continuous curvature instead and lines are run by double S
/// profiles: the path stays the one of `rounded` exactly, only the law of time is smoother, and acceleration
/// is continuous. Throws InvalidArgument for an empty path, numbers that are not finite or limits that are
/// not positive. `limits.tool_speed` must be 0.
[[nodiscard]] JointTrajectory time_path(const JointPath& path, const TimingLimits& limits);
/// Times the path so that the tool (T_F_T on the flange), too, is never faster than `limits.tool_speed`, the
/// robot's own limit and `tool_speed`, if given: asked at points on the path at most 0.05 rad apart.
[[nodiscard]] JointTrajectory time_path(const JointPath& path, const TimingLimits& limits,
                                        const RobotModel& robot, const Pose& T_F_T,
                                        const ToolSpeed& tool_speed = {});

/// Points on the rounded path that `time_path` would follow, neighbours at most `step` rad apart (length of
/// the joint vector) and the lines between them nowhere further than 0.01 mrad from it: what a collision
/// check has to certify.
[[nodiscard]] JointPath rounded(const JointPath& path, const TimingLimits& limits, double step);

}  // namespace stonestack::motion
