#include "motion/cartesian.hpp"

#include <algorithm>
#include <cmath>

#include "kinematics/inverse.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

constexpr int kMaxHalvings = 8;  ///< of a piece; smooth motions need two or three

/// A straight motion of the tool, asked by its share s in [0, 1].
struct Line {
  const RobotModel& robot;
  const Pose& T_F_T;
  const CartesianOptions& options;
  Pose T_R_T_from, T_R_T_goal;
  int branch = 0;

  [[nodiscard]] Pose tool(double s) const { return interpolate(T_R_T_from, T_R_T_goal, s); }
  [[nodiscard]] IkOnBranch solve(double s, const Joints& seed) const {
    return inverse_on_branch(robot, tool(s) * T_F_T.inverse(), seed, branch);
  }
};

/// Appends waypoints after `q0` at s0 up to and with `q1` at s1.
bool refine(const Line& line, JointPath& path, double s0, double s1, const Joints& q1, int halvings) {
  const Joints q0 = path.back(), middle = 0.5 * (q0 + q1);
  const double s = 0.5 * (s0 + s1);
  const PoseDifference off = difference(forward(line.robot, middle) * line.T_F_T, line.tool(s));
  if (off.translation <= line.options.deviation && off.angle <= line.options.angle) {
    path.push_back(q1);
    return true;
  }
  if (halvings == 0) return false;
  const IkOnBranch between = line.solve(s, middle);
  return between.found && refine(line, path, s0, s, between.q, halvings - 1) &&
         refine(line, path, s, s1, q1, halvings - 1);
}

}  // namespace

std::optional<JointPath> straight_path(const RobotModel& robot, const Pose& T_F_T, const Joints& q_from,
                                       const Pose& T_R_T_goal, const CartesianOptions& options) {
  require(q_from.allFinite() && is_valid(T_R_T_goal), "a straight path needs a start and a goal, got ",
          q_from.transpose(), " and ", geometry::to_text(T_R_T_goal));
  require(options.deviation > 0 && options.angle > 0 && options.longest > 0,
          "tolerances of a straight path must be positive");
  const Line line{
      robot, T_F_T, options, forward(robot, q_from) * T_F_T, T_R_T_goal, branch_of(robot, q_from)};
  const PoseDifference change = difference(line.T_R_T_from, T_R_T_goal);
  // A turn counts like the displacement of a point 0.1 m from the tool's tip.
  const int pieces =
      std::max(1, static_cast<int>(std::ceil((change.translation + 0.1 * change.angle) / options.longest)));
  JointPath path{q_from};
  for (int i = 0; i < pieces; ++i) {
    const double s1 = static_cast<double>(i + 1) / pieces;
    const IkOnBranch next = line.solve(s1, path.back());
    if (!next.found || !refine(line, path, static_cast<double>(i) / pieces, s1, next.q, kMaxHalvings))
      return std::nullopt;
  }
  return path;
}

}  // namespace stonestack::motion
