#pragma once
#include <string>

#include "stonestack/kinematics/robot_model.hpp"

/// Private to kinematics: from joint frames to DH parameters.
namespace stonestack::kinematics {

/// Fills d1 ... d6, T_R_D, dh_offset, T_D6_F and `calibrated` from T_parent_joint and T_6_F. Returns why the
/// chain is not UR-like ("axes of elbow and wrist 1 are 3 deg from parallel, ..."), or an empty text.
[[nodiscard]] std::string derive_dh(RobotModel& robot);

/// T_R_F by the DH chain; equal to `forward` unless the robot is calibrated.
[[nodiscard]] Pose forward_dh(const RobotModel& robot, const Joints& q);

}  // namespace stonestack::kinematics
