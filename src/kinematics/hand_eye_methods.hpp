#pragma once
#include <span>
#include <vector>

#include "stonestack/geometry/pose.hpp"

/// Private to kinematics/: closed-form solutions of A X = X B, one function a method.
namespace stonestack::kinematics {

/// A motion of the gripper and the same motion as the camera sees it.
struct HandEyeMotion {
  Pose A = Pose::Identity();
  Pose B = Pose::Identity();
};

/// R. Tsai and R. Lenz 1989: rotation from modified Rodrigues vectors, then translation. No result for a turn
/// of 180 deg.
[[nodiscard]] Pose solve_tsai_lenz(std::span<const HandEyeMotion> motions);

/// F. Park and B. Martin 1994: the rotation that best carries the logarithms over, then translation.
[[nodiscard]] Pose solve_park_martin(std::span<const HandEyeMotion> motions);

/// K. Daniilidis 1999: rotation and translation at once, by dual quaternions.
[[nodiscard]] Pose solve_daniilidis(std::span<const HandEyeMotion> motions);

}  // namespace stonestack::kinematics
