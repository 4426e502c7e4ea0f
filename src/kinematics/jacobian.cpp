#include "kinematics/jacobian.hpp"

#include <Eigen/LU>
#include <cmath>

#include "kinematics/jacobian_of.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::kinematics {

Jacobian jacobian_of(const std::array<Pose, 7>& T_R_link, const Eigen::Vector3d& p_R_F) {
  Jacobian J;
  for (std::size_t i = 0; i < 6; ++i) {
    const Pose& T_R_i = T_R_link[i + 1];
    const Eigen::Vector3d n_R_axis = T_R_i.linear().col(2);
    const auto column = static_cast<Eigen::Index>(i);
    J.block<3, 1>(0, column) = n_R_axis.cross(p_R_F - T_R_i.translation());
    J.block<3, 1>(3, column) = n_R_axis;
  }
  return J;
}

Jacobian jacobian(const RobotModel& robot, const Joints& q) {
  const auto T_R_link = link_poses(robot, q);
  return jacobian_of(T_R_link, (T_R_link[6] * robot.T_6_F).translation());
}

double manipulability(const RobotModel& robot, const Joints& q) {
  return std::abs(jacobian(robot, q).determinant());
}

}  // namespace stonestack::kinematics
