#include "stacking/hand_load.hpp"

#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kPalm = -0.14;           // m, along z of T: middle of palm and fingers
constexpr double kSensorMiddle = 0.0205;  // m, along z of F (half of 41 mm, the height of an FT150)

}  // namespace

HandMass together(const HandMass& a, const HandMass& b) {
  const double total = a.mass + b.mass;
  if (total <= 0) return {};
  return {total, (a.mass * a.p_F_hand + b.mass * b.p_F_hand) / total};
}

HandMass sensed_hand(const GripperModel& gripper, const CellLayout& layout) {
  return together({gripper.mass, layout.T_F_T * Eigen::Vector3d(0, 0, kPalm)},
                  {gripper.camera_mass, (layout.T_F_T * layout.T_T_C).translation()});
}

HandMass carried_hand(const GripperModel& gripper, const CellLayout& layout) {
  return together(sensed_hand(gripper, layout), {gripper.sensor_mass, Eigen::Vector3d(0, 0, kSensorMiddle)});
}

void set_payload(Arm& arm, const HandMass& carried) {
  try {
    arm.set_payload(carried.mass, carried.p_F_hand);
  } catch (const InvalidArgument& refusal) {
    throw DeviceError("arm", concat("does not take the payload: ", refusal.what()),
                      "lighten the hand or the stone, or correct `payload` of the robot");
  }
}

}  // namespace stonestack::stacking
