#pragma once
#include "stacking/wrist.hpp"
#include "stonestack/motion/planning_scene.hpp"

/// Private to stacking/: what hangs on the flange, for the wrist and for the arm.
namespace stonestack::stacking {

/// Gripper and camera: what the force sensor feels always.
[[nodiscard]] HandMass sensed_hand(const GripperModel& gripper, const CellLayout& layout);
/// With the sensor itself: what the arm carries always.
[[nodiscard]] HandMass carried_hand(const GripperModel& gripper, const CellLayout& layout);
/// Both as one.
[[nodiscard]] HandMass together(const HandMass& a, const HandMass& b);

/// Tells the arm what it carries. Throws DeviceError when the arm refuses, also for more than it bears: a
/// plan is made for less, so whoever comes here has no wrong command line to mend.
void set_payload(Arm& arm, const HandMass& carried);

}  // namespace stonestack::stacking
