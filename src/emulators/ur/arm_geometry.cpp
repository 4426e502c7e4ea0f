#include "emulators/ur/arm_geometry.hpp"

#include "kinematics/inverse.hpp"
#include "kinematics/jacobian.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::emulators {

Pose ArmGeometry::T_B_F(const Joints& q) const {
  return robot_.T_R_D.inverse() * forward(robot_, q);
}

bool ArmGeometry::inverse(const Pose& T_B_P, const Joints& seed, bool follow, Joints& q) const {
  const Pose T_R_F = robot_.T_R_D * T_B_P * T_F_P.inverse();
  if (follow) {
    const auto solution = inverse_on_branch(robot_, T_R_F, seed, branch_of(robot_, seed));
    q = solution.q;
    return solution.found;
  }
  const auto solutions = kinematics::inverse(robot_, T_R_F, seed);
  if (solutions.empty()) return false;
  q = solutions.front().q;
  return true;
}

Six ArmGeometry::twist(const Joints& q, const Joints& qd) const {
  const Six at_flange = jacobian(robot_, q) * qd;
  const Eigen::Matrix3d R_B_R = robot_.T_R_D.rotation().transpose();
  Six twist;
  twist.tail<3>() = R_B_R * at_flange.tail<3>();
  const Eigen::Vector3d arm = T_B_F(q).rotation() * T_F_P.translation();
  twist.head<3>() = R_B_R * at_flange.head<3>() + Eigen::Vector3d(twist.tail<3>()).cross(arm);
  return twist;
}

}  // namespace stonestack::emulators
