#pragma once
#include "stacking/wrist.hpp"
#include "stonestack/motion/planning_scene.hpp"

/// Private to stacking/: masses on the flange, for the wrist and for the arm.
namespace stonestack::stacking {

/// Gripper and camera: the constant load on the force sensor.
[[nodiscard]] GripperMass sensed_gripper_mass(const GripperModel& gripper, const CellLayout& layout);
/// Gripper, camera and sensor: the constant load on the arm.
[[nodiscard]] GripperMass carried_gripper_mass(const GripperModel& gripper, const CellLayout& layout);
/// Joins two masses.
[[nodiscard]] GripperMass together(const GripperMass& a, const GripperMass& b);

/// Sends the payload to the arm. Throws DeviceError when the arm refuses it, also for more than it carries:
/// plans respect the payload, so the cause is not a wrong command line.
void set_payload(Arm& arm, const GripperMass& carried);

}  // namespace stonestack::stacking
