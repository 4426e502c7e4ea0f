#pragma once
#include "stonestack/kinematics/robot_model.hpp"

/// Private to kinematics.
namespace stonestack::kinematics {

/// Newton steps on the robot's own chain: for a calibrated robot, whose closed form is only close, and where
/// two singularities meet, so that rounding (its square root) would leave the pose out of reach.
/// False when they do not bring the pose within `tolerance` (norm of metres and radians) of T_R_F.
[[nodiscard]] bool polish(const RobotModel& robot, const Pose& T_R_F, double tolerance, Joints& q);

}  // namespace stonestack::kinematics
