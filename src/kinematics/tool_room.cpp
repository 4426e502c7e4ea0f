#include "stonestack/kinematics/robot_model.hpp"

#include "stonestack/core/error.hpp"

namespace stonestack::kinematics {
namespace {

Eigen::Vector3d tip(const RobotModel& robot, const Joints& q) {
  return (robot.room->T_W_R * forward(robot, q) * robot.room->T_F_T).translation();
}

std::string text(const Eigen::Vector3d& p) {
  return concat("(", p.x(), ", ", p.y(), ", ", p.z(), ")");
}

}  // namespace

double outside_room(const RobotModel& robot, const Joints& q) {
  if (!robot.room) return -1.0;
  const Eigen::Vector3d p = tip(robot, q);
  const auto& box = robot.room->box;
  return (box.min() - p).cwiseMax(p - box.max()).maxCoeff();
}

std::string describe_outside_room(const RobotModel& robot, const Joints& q, double slack) {
  // So that what is not a number is not inside.
  if (!robot.room || (q.allFinite() && outside_room(robot, q) <= slack)) return {};
  return concat("the tool at ", text(tip(robot, q)), " m leaves the workspace, ", text(robot.room->box.min()),
                " to ", text(robot.room->box.max()), " m");
}

}  // namespace stonestack::kinematics
