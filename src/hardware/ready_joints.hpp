#pragma once
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"

/// Private to hardware/, simulation/ and stacking/: where an arm starts that nobody has placed elsewhere.
namespace stonestack::hardware {

/// Fingers down over the middle of the field, or over the nearest place towards the base that can be reached:
/// the camera sees the field from there.
[[nodiscard]] Joints ready_joints(const RobotModel& robot, const CellLayout& layout);

}  // namespace stonestack::hardware
