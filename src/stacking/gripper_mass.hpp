#pragma once
#include "stacking/wrist.hpp"
#include "stonestack/motion/planning_scene.hpp"

/// Private to stacking/: what hangs on the flange, for the wrist and for the arm.
namespace stonestack::stacking {

/// Gripper and camera: what the force sensor feels always.
[[nodiscard]] GripperMass sensed_gripper_mass(const GripperModel& gripper, const CellLayout& layout);
/// With the sensor itself: what the arm carries always.
[[nodiscard]] GripperMass carried_gripper_mass(const GripperModel& gripper, const CellLayout& layout);
/// Both as one.
[[nodiscard]] GripperMass together(const GripperMass& a, const GripperMass& b);

/// Tells the arm what it carries. Throws DeviceError when the arm refuses, also for more than it bears: a
/// plan is made for less, so whoever comes here has no wrong command line to mend.
void set_payload(Arm& arm, const GripperMass& carried);

}  // namespace stonestack::stacking
