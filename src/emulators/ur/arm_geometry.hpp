#pragma once
#include "stonestack/geometry/pose.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::emulators {

/// Six numbers: joints, or translation and rotation vector in the base frame.
using Six = Eigen::Matrix<double, 6, 1>;

/// The arm as its controller computes it. B is the controller's base frame (the DH chain's), which is turned
/// by half a turn about z against the URDF's R; P is the tool centre point.
class ArmGeometry {
 public:
  explicit ArmGeometry(const RobotModel& robot) : robot_(robot) {}
  [[nodiscard]] const RobotModel& robot() const { return robot_; }
  [[nodiscard]] Pose T_B_F(const Joints& q) const;
  [[nodiscard]] Pose T_B_P(const Joints& q) const { return T_B_F(q) * T_F_P; }
  /// Joints near `seed` with the tool at T_B_P; false when out of reach. Keeps the branch when `follow`.
  [[nodiscard]] bool inverse(const Pose& T_B_P, const Joints& seed, bool follow, Joints& q) const;
  /// Velocity of P and angular velocity in B.
  [[nodiscard]] Six twist(const Joints& q, const Joints& qd) const;
  Pose T_F_P = Pose::Identity();

 private:
  RobotModel robot_;
};

}  // namespace stonestack::emulators
