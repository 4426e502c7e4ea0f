#include "stonestack/kinematics/robot_model.hpp"

#include <array>
#include <limits>

#include "stonestack/core/error.hpp"

namespace stonestack::kinematics {
namespace {

Eigen::Vector3d tip(const RobotModel& robot, const Joints& q) {
  return (robot.workspace->T_W_R * forward(robot, q) * robot.workspace->T_F_T).translation();
}

constexpr int kMounted = 7;  // index of what is mounted on the flange, behind the links

/// The point that is furthest outside the fence.
struct Outermost {
  double outside = -std::numeric_limits<double>::infinity();  // m
  int link = 0;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();

  void try_ball(const Eigen::AlignedBox3d& box, int of, const Eigen::Vector3d& centre, double radius) {
    const double out = (box.min() - centre).cwiseMax(centre - box.max()).maxCoeff() + radius;
    if (out > outside) *this = {out, of, centre};
  }
};

/// A capsule is outermost at one of its ends.
Outermost outermost(const RobotModel& robot, const Joints& q) {
  const ArmFence& fence = *robot.fence;
  const auto T_R_link = link_poses(robot, q);
  Outermost most;
  for (const LinkCapsule& capsule : robot.capsules) {
    if (capsule.link < kFirstFencedLink) continue;
    const Pose T_W_link = fence.T_W_R * T_R_link[static_cast<std::size_t>(capsule.link)];
    for (const auto& end : {capsule.a, capsule.b})
      most.try_ball(fence.box, capsule.link, T_W_link * end, capsule.radius);
  }
  const Pose T_W_F = fence.T_W_R * T_R_link[6] * robot.T_6_F;
  for (const auto& p_F : fence.p_F_mounted) most.try_ball(fence.box, kMounted, T_W_F * p_F, 0.0);
  return most;
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

const char* link_name(int link) {
  constexpr std::array<const char*, 7> kNames{"base",    "shoulder", "upper arm", "forearm",
                                              "wrist 1", "wrist 2",  "wrist 3"};
  return kNames.at(static_cast<std::size_t>(link));
}

double outside_fence(const RobotModel& robot, const Joints& q) {
  return robot.fence ? outermost(robot, q).outside : -1.0;
}

std::string describe_outside_fence(const RobotModel& robot, const Joints& q, double slack) {
  if (!robot.fence) return {};
  const Outermost most = outermost(robot, q);
  if (q.allFinite() && most.outside <= slack) return {};  // what is not a number is not inside
  return concat("the ", most.link == kMounted ? "gripper" : link_name(most.link), " at ", text(most.p_W),
                " m leaves the fence, ", text(robot.fence->box.min()), " to ", text(robot.fence->box.max()),
                " m");
}

}  // namespace stonestack::kinematics
