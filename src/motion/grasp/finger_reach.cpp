#include "motion/grasp/finger_reach.hpp"

#include <algorithm>
#include <array>
#include <span>

namespace stonestack::motion {
namespace {

/// Finger tips of the Robotiq 3-finger gripper in a fingertip grip, from the joint origins of its published
/// model (robotiq_3f_gripper_visualization of ros-industrial) to a millimetre.
constexpr std::array<TipAdvance, 7> kTipArc{{{0.0, 0.004},
                                             {0.020, 0.007},
                                             {0.040, 0.009},
                                             {0.070, 0.010},
                                             {0.100, 0.009},
                                             {0.130, 0.005},
                                             {0.155, 0.0}}};

/// The arc of the finger tips; empty: they do not move along z.
std::span<const TipAdvance> arc_of(const GripperModel& gripper) {
  if (gripper.linkage == Linkage::kThreeFinger) return kTipArc;
  if (gripper.linkage == Linkage::kArc) return gripper.tips;
  return {};
}

}  // namespace

double tip_advance(const GripperModel& gripper, double opening) {
  const std::span<const TipAdvance> arc = arc_of(gripper);
  if (arc.empty()) return 0.0;
  const auto next =
      std::find_if(arc.begin(), arc.end(), [&](const TipAdvance& at) { return opening < at.opening; });
  if (next == arc.begin()) return next->advance;
  if (next == arc.end()) return arc.back().advance;
  const TipAdvance &low = *std::prev(next), &high = *next;
  const double share = (opening - low.opening) / (high.opening - low.opening);
  return low.advance + share * (high.advance - low.advance);
}

double furthest_tip(const GripperModel& gripper, double opening, double other) {
  double furthest = std::max(tip_advance(gripper, opening), tip_advance(gripper, other));
  const auto [low, high] = std::minmax(opening, other);
  for (const TipAdvance& at : arc_of(gripper))
    if (low < at.opening && at.opening < high) furthest = std::max(furthest, at.advance);
  return furthest;
}

double finger_inside(const GripperModel& gripper, double opening, double z) {
  const double pad_joint = tip_advance(gripper, opening) - kPadJoint;
  if (gripper.linkage != Linkage::kThreeFinger || z > pad_joint) return 0.5 * opening;
  const double share = std::max(0.0, (z + kPalmJoint) / (pad_joint + kPalmJoint));
  return kPalmJointAside + share * (0.5 * opening + kPadJointAside - kPalmJointAside) - kLinkInside;
}

Eigen::Vector3d box_centre(const GripperModel& gripper, const GripperBox& box, double opening) {
  Eigen::Vector3d centre = box.p_T_centre + 0.5 * opening * box.finger_side * Eigen::Vector3d::UnitX();
  if (box.advance != 0.0) centre.z() += box.advance * tip_advance(gripper, opening);
  return centre;
}

}  // namespace stonestack::motion
