#include "stacking/gripper_mass.hpp"

#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kSensorMiddle = 0.0205;  // m, along z of F (half of 41 mm, the height of an FT150)

}  // namespace

GripperMass together(const GripperMass& a, const GripperMass& b) {
  const double total = a.mass + b.mass;
  if (total <= 0) return {};
  return {total, (a.mass * a.p_F_gripper + b.mass * b.p_F_gripper) / total};
}

GripperMass sensed_gripper_mass(const GripperModel& gripper, const CellLayout& layout) {
  return together({gripper.mass, layout.T_F_T * Eigen::Vector3d(0, 0, gripper.centre_of_mass)},
                  {gripper.camera_mass, (layout.T_F_T * layout.T_T_C).translation()});
}

GripperMass carried_gripper_mass(const GripperModel& gripper, const CellLayout& layout) {
  return together(sensed_gripper_mass(gripper, layout),
                  {gripper.sensor_mass, Eigen::Vector3d(0, 0, kSensorMiddle)});
}

void set_payload(Arm& arm, const GripperMass& carried) {
  try {
    arm.set_payload(carried.mass, carried.p_F_gripper);
  } catch (const InvalidArgument& refusal) {
    throw DeviceError("arm", concat("does not take the payload: ", refusal.what()),
                      "lighten the gripper or the stone, or correct `payload` of the robot");
  }
}

}  // namespace stonestack::stacking
