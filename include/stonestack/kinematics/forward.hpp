#pragma once
#include <array>

#include "stonestack/kinematics/robot_model.hpp"

#pragma GCC visibility push(default)

namespace stonestack::kinematics {

/// T_R_F of the flange.
[[nodiscard]] Pose forward(const RobotModel& robot, const Joints& q);
/// T_R_link for links 0..6 (0: base).
[[nodiscard]] std::array<Pose, 7> link_poses(const RobotModel& robot, const Joints& q);

}  // namespace stonestack::kinematics

#pragma GCC visibility pop
