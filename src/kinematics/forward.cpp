#include "stonestack/kinematics/robot_model.hpp"

#include <cmath>

namespace stonestack::kinematics {
namespace {

/// `T` turned about its own z.
Pose turned(const Pose& T, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  Pose out = T;
  out.linear().col(0) = c * T.linear().col(0) + s * T.linear().col(1);
  out.linear().col(1) = c * T.linear().col(1) - s * T.linear().col(0);
  return out;
}

}  // namespace

std::array<Pose, 7> link_poses(const RobotModel& robot, const Joints& q) {
  std::array<Pose, 7> T_R_link;
  T_R_link[0] = Pose::Identity();
  for (std::size_t i = 0; i < 6; ++i)
    T_R_link[i + 1] = turned(T_R_link[i] * robot.T_parent_joint[i], q[static_cast<Eigen::Index>(i)]);
  return T_R_link;
}

Pose forward(const RobotModel& robot, const Joints& q) {
  return link_poses(robot, q)[6] * robot.T_6_F;
}

}  // namespace stonestack::kinematics
