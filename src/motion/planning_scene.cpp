#include "stonestack/motion/planning_scene.hpp"

namespace stonestack {
namespace {

// Lengths along z of T, from the finger tips backwards (facts: public meshes of gripper and sensor), metres.
constexpr double kPalmFront = 0.112;
constexpr double kPalmBack = 0.223;
constexpr double kFlange = 0.264;
constexpr double kFingerThickness = 0.020;

/// A box that fills x and y as given and z from `back` to `front` behind the tips.
GripperBox box_behind_tip(double size_x, double size_y, double front, double back) {
  return {{size_x, size_y, back - front}, {0.0, 0.0, -0.5 * (front + back)}, 0.0};
}

/// A finger from palm to tip whose pad lies on x = 0 when closed and that opens towards `side`.
GripperBox finger(double width, double y, double side) {
  return {{kFingerThickness, width, kPalmFront}, {0.5 * side * kFingerThickness, y, -0.5 * kPalmFront}, side};
}

}  // namespace

GripperModel make_robotiq_3f() {
  GripperModel gripper;
  const double half_spacing = 0.5 * gripper.finger_spacing;
  gripper.boxes = {
      finger(gripper.finger_width, 0.0, 1.0),
      finger(gripper.finger_width, half_spacing, -1.0),
      finger(gripper.finger_width, -half_spacing, -1.0),
      box_behind_tip(0.135, 0.130, kPalmFront, kPalmBack),
      box_behind_tip(0.120, 0.120, kPalmBack, kFlange),
      // Camera with its bracket, beside the palm at +y and wholly behind the optical centre of the default
      // mount (CellLayout::make_default_T_T_C), so that it stays out of the view.
      {{0.110, 0.060, 0.042}, {0.0, 0.095, -0.193}, 0.0},
  };
  return gripper;
}

}  // namespace stonestack
