#include "stonestack/kinematics/robot_model.hpp"

#include "stonestack/core/error.hpp"

namespace stonestack::kinematics {
namespace {

Eigen::Vector3d tip(const RobotModel& robot, const Joints& q) {
  return (robot.workspace->T_W_R * forward(robot, q) * robot.workspace->T_F_T).translation();
}

std::string text(const Eigen::Vector3d& p) {
  return concat("(", p.x(), ", ", p.y(), ", ", p.z(), ")");
}

}  // namespace

double outside_workspace(const RobotModel& robot, const Joints& q) {
  if (!robot.workspace) return -1.0;
  const Eigen::Vector3d p = tip(robot, q);
  const auto& box = robot.workspace->box;
  return (box.min() - p).cwiseMax(p - box.max()).maxCoeff();
}

std::string describe_outside_workspace(const RobotModel& robot, const Joints& q, double slack) {
  // So that what is not a number is not inside.
  if (!robot.workspace || (q.allFinite() && outside_workspace(robot, q) <= slack)) return {};
  return concat("the tool at ", text(tip(robot, q)), " m leaves the workspace, ",
                text(robot.workspace->box.min()), " to ", text(robot.workspace->box.max()), " m");
}

}  // namespace stonestack::kinematics
