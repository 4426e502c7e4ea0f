#include "stonestack/kinematics/hand_eye.hpp"

#include <cmath>

#include "core/constants.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::kinematics {
namespace {

/// Camera over a board at the origin of B (z out of the board), seen from a random side.
Pose random_view(Random& random) {
  const double tilt = random.uniform(0.2, 0.95), azimuth = random.uniform(0.0, 2.0 * kPi);
  const Eigen::Vector3d from(std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth),
                             std::cos(tilt));
  Pose T_B_C = Pose::Identity();
  const Eigen::Vector3d x = from.unitOrthogonal();
  T_B_C.linear() << x, -from.cross(x), -from;
  T_B_C.translation() = random.uniform(0.4, 0.7) * from;
  return T_B_C * Eigen::AngleAxisd(random.uniform(-1.5, 1.5), Eigen::Vector3d::UnitZ());
}

Pose disturbed(const Pose& T, double translation, double rotation, Random& random) {
  const Eigen::Vector3d t(random.normal(), random.normal(), random.normal());
  const Eigen::Vector3d w = rotation * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
  Pose off = make_pose(translation * t);
  if (w.norm() > 0) off.rotate(Eigen::AngleAxisd(w.norm(), w.normalized()));
  return T * off;
}

}  // namespace

std::vector<HandEyePair> simulate_hand_eye(const Pose& T_A_C, CameraMount mount, int count,
                                           const HandEyeNoise& noise, Random random) {
  require(count >= 1, "stations to simulate must be at least 1, got ", count);
  // With the camera on the gripper the board's place in the base is fixed; otherwise its place in the gripper
  // is.
  const Pose T_fixed_B = mount == CameraMount::kOnHand
                             ? make_pose({0.6, 0.1, 0.02}, Eigen::Quaterniond(0.9, 0.05, -0.03, 0.4))
                             : make_pose({0.01, 0.03, 0.12}, Eigen::Quaterniond(0.8, 0.1, 0.5, 0.2));
  std::vector<HandEyePair> pairs;
  for (int i = 0; i < count; ++i) {
    const Pose T_C_B = random_view(random).inverse();
    const Pose T_R_F = mount == CameraMount::kOnHand ? Pose(T_fixed_B * T_C_B.inverse() * T_A_C.inverse())
                                                     : Pose(T_A_C * T_C_B * T_fixed_B.inverse());
    pairs.push_back({disturbed(T_R_F, noise.arm_translation, noise.arm_rotation, random),
                     disturbed(T_C_B, noise.target_translation, noise.target_rotation, random)});
  }
  return pairs;
}

}  // namespace stonestack::kinematics
