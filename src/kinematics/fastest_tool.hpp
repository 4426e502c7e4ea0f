#pragma once
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::kinematics {

/// Largest speed (m/s) of the tool's tip (T_F_T on the flange) along a trajectory, as means over 8 ms, the
/// control step of a CB3; 0 for an empty one.
[[nodiscard]] double fastest_tool(const JointTrajectory& trajectory, const RobotModel& robot,
                                  const Pose& T_F_T);

}  // namespace stonestack::kinematics
