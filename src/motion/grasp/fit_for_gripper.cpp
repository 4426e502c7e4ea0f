#include "stonestack/motion/planning_scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "motion/regrasp.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::motion {
namespace {

constexpr int kTurns = 90;  // of half a turn

double width_along(const Mesh& scan, const Eigen::Vector3d& n_O) {
  double min = std::numeric_limits<double>::infinity(), max = -min;
  for (const Eigen::Vector3d& p : scan.vertices) {
    min = std::min(min, n_O.dot(p));
    max = std::max(max, n_O.dot(p));
  }
  return max - min;
}

}  // namespace

double min_width_at_rest(const Stone& stone) {
  double min = std::numeric_limits<double>::infinity();
  for (const RestPose& rest : rest_poses(stone))
    for (int k = 0; k < kTurns; ++k) {
      const double angle = std::numbers::pi * k / kTurns;
      const Eigen::Vector3d n_W(std::cos(angle), std::sin(angle), 0.0);
      min = std::min(min, width_along(stone.scan, rest.R_W_O.conjugate() * n_W));
    }
  return std::isfinite(min) ? min : 0.0;
}

std::string unfit_for_gripper(const Stone& stone, const GripperModel& gripper) {
  RobotModel any;
  any.payload = std::numeric_limits<double>::infinity();
  return unfit_for_gripper(stone, gripper, any);
}

std::string overload(double mass, const GripperModel& gripper, const RobotModel& robot) {
  if (mass > gripper.payload) return concat("the fingers carry ", gripper.payload, " kg");
  const double gripper_mass = carried_mass(gripper);
  if (gripper_mass >= robot.payload)
    return concat(robot.name, " carries ", robot.payload, " kg, its gripper with sensor and camera is ",
                  gripper_mass, " kg");
  if (gripper_mass + mass > robot.payload)
    return concat(robot.name, " carries ", robot.payload, " kg, ", gripper_mass,
                  " kg of them the gripper with sensor and camera");
  return {};
}

std::string unfit_for_gripper(const Stone& stone, const GripperModel& gripper, const RobotModel& robot) {
  if (const std::string who = overload(stone.mass.mass, gripper, robot); !who.empty())
    return concat(stone.mass.mass, " kg, ", who);
  if (const double width = min_width_at_rest(stone); width > gripper.max_opening)
    return concat(std::lround(1e3 * width), " mm across, the fingers open ",
                  std::lround(1e3 * gripper.max_opening), " mm");
  return {};
}

std::vector<StoneIndex> draw_stones(const Catalogue& catalogue, int count, int seed,
                                    const GripperModel& gripper, const RobotModel& robot) {
  std::vector<StoneIndex> order = first_stones(catalogue.stones.size());
  Random::stream(static_cast<std::uint64_t>(seed), "stones of the run").shuffle(order.begin(), order.end());
  std::string unfit;
  std::erase_if(order, [&](StoneIndex k) {
    const Stone& stone = catalogue[k];
    const std::string why = unfit_for_gripper(stone, gripper, robot);
    if (!why.empty()) unfit += concat(unfit.empty() ? "" : ", ", stone.name, " (", why, ")");
    return !why.empty();
  });
  if (order.empty())
    throw Error("no stone of the catalogue can be carried: " + unfit, ExitCode::kExecutionFailed);
  if (!unfit.empty()) log_info("not drawn, for gripper or arm cannot hold them: " + unfit);
  order.resize(std::min(order.size(), static_cast<std::size_t>(count)));
  std::sort(order.begin(), order.end());
  return order;
}

}  // namespace stonestack::motion
