#include "stonestack/motion/planning_scene.hpp"

#include <cmath>

#include "motion/collision/gripper_linkage.hpp"
#include "motion/grasp/finger_reach.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::motion {
namespace {

// Lengths along z of T, from the finger tips backwards (from the public meshes of gripper and sensor),
// metres.
constexpr double kPalmFront = 0.112;
constexpr double kPalmBack = 0.223;
constexpr double kFlange = 0.264;
constexpr double kFingerThickness = 0.020;
constexpr double kKnuckle =
    0.056;  // design choice: halfway; fingers B and C turn at the palm, so their bases move less
constexpr double kMountShift =
    0.010;                            // a mount that a calibration corrects by less is the one that was drawn
constexpr double kMountTurn = 0.052;  // rad, the same
constexpr double kBaseSpread =
    0.5;  // of what the pads move; with the base's middle 35 mm in front of the palm

// Three parts of each finger of kThreeFinger, which leans between its joints (finger_reach.hpp). The pad's
// part moves with the tip; the others go where their middle lies on the line of joints.
constexpr double kPadPart = 0.044;                       // m behind the tip
constexpr double kLinkEnd = 0.024, kLinkMiddle = 0.075;  // m behind the origin of T
constexpr double kLinkThickness = 0.036;                 // m: 30 mm, and how far a part leans over its length

/// A box that fills x and y as given and z from `back` to `front` behind the tips.
GripperBox box_behind_tip(double size_x, double size_y, double front, double back) {
  return {{size_x, size_y, back - front}, {0.0, 0.0, -0.5 * (front + back)}, 0.0};
}

/// A finger from `front` to `back` behind the tip whose pad lies on x = 0 when closed and that opens towards
/// `side`.
GripperBox finger(double width, double y, double side, double front, double back) {
  return {{kFingerThickness, width, back - front},
          {0.5 * side * kFingerThickness, y, -0.5 * (front + back)},
          side};
}

/// Finger B (`y` > 0) or C in two parts: its base stands closer to where it turns than its tip.
void add_turning_finger(std::vector<GripperBox>& boxes, double width, double y) {
  const double side = y > 0 ? 0.5 : -0.5;
  boxes.push_back(finger(width, y, -1.0, 0.0, kKnuckle));
  boxes.back().spread = side;
  boxes.push_back(finger(width, y, -1.0, kKnuckle, kPalmFront));
  boxes.back().spread = side * kBaseSpread;
}

/// Part of a finger of kThreeFinger from `front` to `back` behind the origin of T, on the leaning line.
GripperBox link_part(double width, double y, double side, double front, double back) {
  const double share =
      (kPalmJoint - 0.5 * (front + back)) / (kPalmJoint - kPadJoint);  // of what the pad moves
  const double aside = kPalmJointAside + share * (kPadJointAside - kPalmJointAside) - kLinkInside;
  GripperBox box = finger(width, y, side, front, back);
  box.size.x() = kLinkThickness;
  box.p_T_centre.x() = side * (aside + 0.5 * kLinkThickness);
  box.finger_side = share * side;
  box.spread = y == 0.0 ? 0.0 : std::copysign(0.5 * share, y);
  return box;
}

void add_three_finger(std::vector<GripperBox>& boxes, double width, double y, double side) {
  boxes.push_back(finger(width, y, side, 0.0, kPadPart));
  boxes.back().advance = 1.0;
  boxes.back().spread = y == 0.0 ? 0.0 : std::copysign(0.5, y);
  boxes.push_back(link_part(width, y, side, kLinkEnd, kLinkMiddle));
  boxes.push_back(link_part(width, y, side, kLinkMiddle, kPalmFront));
}

/// The mount that the camera's box was drawn for: CellLayout::make_default_T_T_C(), in hardware/, for the
/// 3-finger gripper, and the same place on the flange for others.
Pose drawn_mount(const GripperModel& gripper) {
  constexpr double kTilt = 10.0 * 3.14159265358979323846 / 180.0;
  const double longer = gripper.tip - GripperModel{}.tip;
  return Eigen::Translation3d(0.0, 0.110, -0.170 - longer) *
         Eigen::AngleAxisd(kTilt, Eigen::Vector3d::UnitX());
}

void draw_three_fingers(GripperModel& gripper) {
  const double half_spacing = 0.5 * gripper.finger_spacing;
  std::erase_if(gripper.boxes, [](const GripperBox& box) { return box.finger_side != 0.0; });
  add_three_finger(gripper.boxes, gripper.finger_width, 0.0, 1.0);
  add_three_finger(gripper.boxes, gripper.finger_width, half_spacing, -1.0);
  add_three_finger(gripper.boxes, gripper.finger_width, -half_spacing, -1.0);
}

}  // namespace

Linkage linkage_named(const std::string& name) {
  require(name == "parallel" || name == "three_finger",
          "there are the linkages parallel and three_finger; got '", name, "'");
  return name == "parallel" ? Linkage::kParallel : Linkage::kThreeFinger;
}

GripperModel make_robotiq_3f(Linkage linkage) {
  GripperModel gripper;
  gripper.linkage = linkage;
  const double half_spacing = 0.5 * gripper.finger_spacing;
  gripper.boxes = {
      finger(gripper.finger_width, 0.0, 1.0, 0.0, kPalmFront),
      box_behind_tip(0.135, 0.130, kPalmFront, kPalmBack),
      box_behind_tip(0.120, 0.120, kPalmBack, kFlange),
      // Camera with its bracket, beside the palm at +y and wholly behind the optical centre of the default
      // mount (CellLayout::make_default_T_T_C), so that it stays out of the view.
      {{0.110, 0.060, 0.042}, {0.0, 0.095, -0.193}, 0.0, 0.0, true},
  };
  if (linkage == Linkage::kThreeFinger) {
    draw_three_fingers(gripper);
    return gripper;
  }
  add_turning_finger(gripper.boxes, gripper.finger_width, half_spacing);
  add_turning_finger(gripper.boxes, gripper.finger_width, -half_spacing);
  return gripper;
}

GripperModel draw_linkage(GripperModel gripper, Linkage linkage) {
  gripper.linkage = linkage;
  if (linkage == Linkage::kParallel) return gripper;
  if (gripper.name == GripperModel{}.name && gripper.against == 2)
    draw_three_fingers(gripper);
  else
    gripper.linkage = gripper.tips.empty() ? Linkage::kParallel : Linkage::kArc;
  return gripper;
}

double sensed_mass(const GripperModel& gripper) {
  return gripper.mass + gripper.camera_mass;
}

double carried_mass(const GripperModel& gripper) {
  return sensed_mass(gripper) + gripper.sensor_mass;
}

GripperModel with_spacing(GripperModel gripper, double spacing) {
  require(spacing == gripper.finger_spacing ||
              (gripper.narrow_spacing > 0 && spacing >= gripper.narrow_spacing - 1e-9 &&
               spacing < gripper.finger_spacing),
          "fingers B and C of ", gripper.name, " can be from ", gripper.narrow_spacing, " to ",
          gripper.finger_spacing, " m apart, not ", spacing, " m");
  for (GripperBox& box : gripper.boxes) box.p_T_centre.y() += box.spread * (spacing - gripper.finger_spacing);
  gripper.finger_spacing = spacing;
  return gripper;
}

GripperModel with_camera_at(GripperModel gripper, const Pose& T_T_C) {
  require(is_valid(T_T_C), "the camera's mount is not a rigid transform: ", geometry::to_text(T_T_C));
  const Pose drawn = drawn_mount(gripper);
  const PoseDifference off = difference(T_T_C, drawn);
  if (off.translation < kMountShift && off.angle < kMountTurn) return gripper;
  const Pose moved = T_T_C * drawn.inverse();
  for (GripperBox& box : gripper.boxes) {
    if (!box.camera) continue;
    box.p_T_centre = moved * box.p_T_centre;
    box.size = moved.linear().cwiseAbs() * box.size;
  }
  return gripper;
}

double padding_between(const PlanningScene& scene, const std::string& part, const std::string& link,
                       const std::string& stands, double padding) {
  if (padding == 0.0) return padding;
  for (const PairPadding& pair : scene.paddings)
    if ((pair.a == part || pair.a == link) && pair.b == stands) padding = pair.m;
  return padding;
}

}  // namespace stonestack::motion
