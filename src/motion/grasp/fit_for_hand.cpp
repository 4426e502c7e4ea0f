#include "stonestack/motion/planning_scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "motion/regrasp.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::motion {
namespace {

constexpr int kTurns = 90;  // of half a turn

double width_along(const Mesh& scan, const Eigen::Vector3d& n_O) {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const Eigen::Vector3d& p : scan.vertices) {
    least = std::min(least, n_O.dot(p));
    most = std::max(most, n_O.dot(p));
  }
  return most - least;
}

}  // namespace

double least_width_at_rest(const Stone& stone) {
  double least = std::numeric_limits<double>::infinity();
  for (const RestPose& rest : rest_poses(stone))
    for (int k = 0; k < kTurns; ++k) {
      const double angle = std::numbers::pi * k / kTurns;
      const Eigen::Vector3d n_W(std::cos(angle), std::sin(angle), 0.0);
      least = std::min(least, width_along(stone.scan, rest.R_W_O.conjugate() * n_W));
    }
  return std::isfinite(least) ? least : 0.0;
}

std::string unfit_for_hand(const Stone& stone, const GripperModel& gripper) {
  RobotModel any;
  any.payload = std::numeric_limits<double>::infinity();
  return unfit_for_hand(stone, gripper, any);
}

std::string overload(double mass, const GripperModel& gripper, const RobotModel& robot) {
  if (mass > gripper.payload) return concat("the fingers carry ", gripper.payload, " kg");
  const double hand = carried_mass(gripper);
  if (hand >= robot.payload)
    return concat(robot.name, " carries ", robot.payload, " kg, its hand with sensor and camera is ", hand,
                  " kg");
  if (hand + mass > robot.payload)
    return concat(robot.name, " carries ", robot.payload, " kg, ", hand,
                  " kg of them the hand with sensor and camera");
  return {};
}

std::string unfit_for_hand(const Stone& stone, const GripperModel& gripper, const RobotModel& robot) {
  if (const std::string who = overload(stone.mass.mass, gripper, robot); !who.empty())
    return concat(stone.mass.mass, " kg, ", who);
  if (const double width = least_width_at_rest(stone); width > gripper.largest_opening)
    return concat(std::lround(1e3 * width), " mm across, the fingers open ",
                  std::lround(1e3 * gripper.largest_opening), " mm");
  return {};
}

}  // namespace stonestack::motion
