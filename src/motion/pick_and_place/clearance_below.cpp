#include "motion/clearance_below.hpp"

#include <algorithm>

#include "motion/cartesian.hpp"
#include "motion/constants.hpp"
#include "motion/pick_and_place/pick_attempt.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

constexpr double kFineness = 0.001;  ///< [m]

/// True if the user set a padding between gripper and table.
bool is_kept_off_table(const PlanningScene& scene) {
  return std::any_of(scene.paddings.begin(), scene.paddings.end(),
                     [](const PairPadding& pair) { return pair.a == "hand" && pair.b == "table"; });
}

}  // namespace

double clearance_below(const PlanningScene& scene, const Joints& q, double opening, int object, double max) {
  require(max >= 0, "a descent goes down by something, not by ", max, " m");
  CollisionRules rules;
  rules.padding = kDescentPadding;
  rules.opening = opening;
  if (!is_kept_off_table(scene)) rules.gripper_may_touch = {kTableObject};
  rules.left_out = object;
  const CollisionChecker checker(scene, rules);
  const Pose T_R_T = forward(scene.robot, q) * scene.T_F_T;
  const Eigen::Vector3d n_R_down = -(scene.T_W_R.linear().transpose() * Eigen::Vector3d::UnitZ());
  const auto has_clearance = [&](double down) {
    const Pose T_R_T_low = Eigen::Translation3d(down * n_R_down) * T_R_T;
    const auto path = straight_path(scene.robot, scene.T_F_T, q, T_R_T_low);
    return path && is_free(checker, *path);
  };
  if (has_clearance(max)) return max;
  double clearance = 0.0;
  for (double taken = max; taken - clearance > kFineness;) {
    const double middle = 0.5 * (clearance + taken);
    (has_clearance(middle) ? clearance : taken) = middle;
  }
  return clearance;
}

}  // namespace stonestack::motion
