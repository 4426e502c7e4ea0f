#pragma once

#include "stonestack/core/rooms.hpp"

namespace stonestack::simulation {

/// A finger of the Robotiq 3-finger gripper in a fingertip grip, in the plane in which it closes: the first
/// two phalanges turn as one link about the palm's joint, and the mechanism keeps the last one, with the pad,
/// upright, until the pads meet (theta_2 = 0, theta_3 = -theta_1: Franchi and Hauser, "Use of Hybrid Systems
/// to model the RobotiQ Adaptive Gripper", 2014, section 4.1).
///
/// Joint origins, limits and meshes: robotiq_3f_gripper_visualization of ros-industrial. Heights are along
/// the palm's normal, from the face by which the gripper is mounted; distances are from the middle between
/// pads.
struct FingerLinkage {
  double theta_1 = 0.0;      ///< angle of the palm's joint [rad]
  double lean = 0.0;         ///< of the link from the palm's normal, towards the middle [rad]
  double knuckle = 0.0;      ///< distance of the last phalanx' joint from the middle [m]
  double knuckle_top = 0.0;  ///< its height [m]
  double tip = 0.0;          ///< height of the finger tip [m]
};
/// Posture with the pad `place` (m) from the middle, as far as the joint turns; the ends of its range beyond.
[[nodiscard]] FingerLinkage finger_linkage(double place);

inline constexpr double kFirstJointAside = 0.0455;  ///< distance of the palm's joint from the middle [m]
inline constexpr double kFirstJointTop = 0.0988;    ///< its height [m]
inline constexpr double kLinkLength = 0.0963;       ///< from it to the last phalanx' joint [m]
inline constexpr double kPadInside = 0.0111;  ///< of that joint, towards the middle, lies the pad's face [m]
inline constexpr double kLastPhalanx = 0.0381;  ///< from that joint to the tip [m]
inline constexpr double kOpenTip = 0.223;       ///< height of the tip when fully open, where z of T is 0 [m]

}  // namespace stonestack::simulation
