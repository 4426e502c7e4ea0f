#include "simulation/gripper_body.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "motion/grasp/finger_reach.hpp"
#include "simulation/finger_linkage.hpp"

namespace stonestack::simulation {
namespace {

constexpr std::array<double, kFingers> kSide{1.0, -1.0, -1.0};

// Phalanges, after the meshes. The first two are one box along the line between their joints, the last one a
// box behind its pad; the two overlap.
constexpr double kLinkInside = 0.005, kLinkOutside = 0.025;  // m, of that line
constexpr double kLinkBehind = 0.010;                        // m, of the palm's joint
constexpr double kTipOutside = 0.0091;                       // m, of the last phalanx' joint
constexpr double kTipLength = 0.044;                         // m
constexpr double kLinkSpread = 0.35;  // of what the tips of B and C move; design choice

double finger_y(const GripperModel& gripper, int finger, double narrowed) {
  if (finger == 0) return 0.0;
  return (finger == 1 ? 0.5 : -0.5) * (gripper.finger_spacing - narrowed);
}

/// z of T where the tip of a finger stands.
double tip_z(const GripperBody& model, double place) {
  return model.phalanges ? finger_linkage(place).tip - kOpenTip : tip_advance(model.gripper, 2.0 * place);
}

/// Returns the first two phalanges and the last one of a finger.
std::array<GripperPart, 2> make_phalanges(const GripperBody& model, int finger) {
  const double side = kSide[static_cast<std::size_t>(finger)], width = model.gripper.finger_width;
  const double y = finger_y(model.gripper, finger, 0.0), spread = finger == 0 ? 0.0 : std::copysign(0.5, y);
  GripperPart link, tip;
  link.size = {kLinkInside + kLinkOutside, width, kLinkBehind + kLinkLength};
  link.p_T_centre = {0.5 * side * (kLinkOutside - kLinkInside), y, 0.5 * (kLinkLength - kLinkBehind)};
  link.spread = kLinkSpread * spread;
  link.leans = true;
  const double inside = kPadInside - model.pad.thickness;  // of the joint lies the bone behind the rubber
  tip.size = {inside + kTipOutside, width, kTipLength};
  tip.p_T_centre = {side * (model.pad.thickness + 0.5 * tip.size.x()), y, -0.5 * kTipLength};
  tip.spread = spread;
  for (GripperPart* part : {&link, &tip}) {
    part->finger = finger;
    part->side = side;
  }
  return {link, tip};
}

/// Pose in T of a box of the first two phalanges.
Pose leaning_pose(const GripperPart& box, double place, double y) {
  const double lean = -box.side * finger_linkage(place).lean;
  const Pose T_T_joint = Eigen::Translation3d(box.side * kFirstJointAside, y, kFirstJointTop - kOpenTip) *
                         Eigen::AngleAxisd(lean, Eigen::Vector3d::UnitY());
  return T_T_joint * Eigen::Translation3d(box.p_T_centre.x(), 0.0, box.p_T_centre.z());
}

}  // namespace

double opening(const GripperPose& gripper_pose) {
  return gripper_pose.finger[0] + 0.5 * (gripper_pose.finger[1] + gripper_pose.finger[2]);
}

GripperBody make_gripper_body(const GripperModel& gripper, const std::string& linkage) {
  GripperBody model{gripper, {}, {}};
  const bool arc = linkage_named(linkage) == Linkage::kThreeFinger;
  model.phalanges = arc && gripper.against == 2 && gripper.tips.empty();
  model.gripper.linkage = arc && !gripper.tips.empty() ? Linkage::kArc : Linkage::kParallel;
  model.pad.width = gripper.finger_width;
  model.pad.length = gripper.pad_length;
  for (const auto& box : gripper.boxes) {
    if (model.phalanges && box.finger_side != 0.0) continue;
    GripperPart part{box.size, box.p_T_centre, -1, box.spread, box.finger_side, box.camera};
    if (box.finger_side != 0.0) {
      part.finger = box.finger_side > 0 ? 0 : gripper.against == 1 || box.p_T_centre.y() > 0 ? 1 : 2;
      part.size.x() -= model.pad.thickness;
      part.p_T_centre.x() += 0.5 * box.finger_side * model.pad.thickness;
    }
    model.boxes.push_back(part);
  }
  for (int finger = 0; model.phalanges && finger < kFingers; ++finger)
    for (const GripperPart& part : make_phalanges(model, finger)) model.boxes.push_back(part);
  return model;
}

std::array<double, kFingers> next_finger_places(const GripperBody& model,
                                                std::array<FingerDriveState, kFingers>& drives,
                                                const std::array<double, kFingers>& places,
                                                const std::array<double, kFingers>& force, double seconds) {
  std::array<double, kFingers> next{};
  if (model.gripper.against == 1) {
    next.fill(next_finger_place(drives[0], places[0], 0.5 * (force[0] + force[1]), seconds));
    drives[1].holding = drives[2].holding = drives[0].holding;
    return next;
  }
  for (std::size_t f = 0; f < next.size(); ++f)
    next[f] = next_finger_place(drives[f], places[f], force[f], seconds);
  return next;
}

Pose box_pose(const GripperBody& model, const GripperPart& box, const GripperPose& gripper_pose) {
  Eigen::Vector3d p_T = box.p_T_centre;
  p_T.y() -= box.spread * gripper_pose.narrowed;
  if (box.finger >= 0) {
    const double place = gripper_pose.finger[static_cast<std::size_t>(box.finger)];
    if (box.leans) return gripper_pose.T_W_T * leaning_pose(box, place, p_T.y());
    p_T.x() += box.side * place;
    p_T.z() += tip_z(model, place);
  }
  return gripper_pose.T_W_T * make_pose(p_T);
}

Pose pad_pose(const GripperBody& model, int finger, const GripperPose& gripper_pose) {
  const auto f = static_cast<std::size_t>(finger);
  Pose T_T_P = Pose::Identity();
  T_T_P.translation() = Eigen::Vector3d(
      kSide[f] * gripper_pose.finger[f], finger_y(model.gripper, finger, gripper_pose.narrowed),
      tip_z(model, gripper_pose.finger[f]) - 0.5 * model.gripper.pad_length);
  const Eigen::Vector3d z(-kSide[f], 0, 0), x(0, 0, 1);
  T_T_P.linear() << x, z.cross(x), z;
  return gripper_pose.T_W_T * T_T_P;
}

double distance_to_gripper(const GripperBody& model, const GripperPose& gripper_pose,
                           const Eigen::Vector3d& p_W) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& box : model.boxes) {
    const Eigen::Vector3d p = box_pose(model, box, gripper_pose).inverse() * p_W;
    nearest = std::min(nearest, (p.cwiseAbs() - 0.5 * box.size).cwiseMax(0.0).norm());
  }
  return nearest;
}

Eigen::Vector3d lowest_corner(const GripperBody& model, const GripperPose& gripper_pose,
                              const GroundHeight& ground) {
  Eigen::Vector3d lowest = Eigen::Vector3d::Zero();
  double least = std::numeric_limits<double>::infinity();
  for (const auto& box : model.boxes) {
    const Pose T_W_box = box_pose(model, box, gripper_pose);
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d sign(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
      const Eigen::Vector3d p_W = T_W_box * sign.cwiseProduct(box.size);
      const double height = ground ? p_W.z() - ground(p_W) : p_W.z();
      if (height >= least) continue;
      least = height;
      lowest = p_W;
    }
  }
  return lowest;
}

}  // namespace stonestack::simulation
