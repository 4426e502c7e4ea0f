#include <algorithm>

#include "motion/cartesian.hpp"
#include "motion/transit.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

constexpr double kStep = 0.02;      // m
constexpr int kMaxSteps = 6;        // of them
constexpr double kNearer = 0.0002;  // m that a sample may be nearer than the one before

}  // namespace

bool comes_away(const CollisionChecker& checker, const JointPath& path) {
  double before = checker.clearance(path.front()).distance;
  for (std::size_t i = 1; i < path.size(); ++i)
    for (const double t : {0.25, 0.5, 0.75, 1.0}) {
      const Joints q = path[i - 1] + t * (path[i] - path[i - 1]);
      const double now = checker.clearance(q).distance;
      if (now < before - kNearer && checker.collides(q)) return false;
      before = now;
    }
  return !checker.collides(path.back());
}

std::optional<JointPath> escape_path(const PlanningScene& scene, const Joints& start,
                                     const MotionOptions& options) {
  CollisionRules rules;
  rules.padding = std::min(options.approach_padding, options.transit_padding);
  rules.self_padding = std::min(rules.self_padding, rules.padding);
  rules.opening = scene.opening;
  const CollisionChecker checker(scene, rules);
  if (!checker.collides(start)) return JointPath{start};
  const Pose T_R_T = forward(scene.robot, start) * scene.T_F_T;
  const Eigen::Vector3d back = -T_R_T.linear().col(2);
  const Eigen::Vector3d up = scene.T_W_R.linear().transpose() * Eigen::Vector3d::UnitZ();
  for (int steps = 1; steps <= kMaxSteps; ++steps)
    for (const Eigen::Vector3d& along : {back, up, Eigen::Vector3d((back + up).normalized())}) {
      const Pose T_R_T_goal = Eigen::Translation3d(steps * kStep * along) * T_R_T;
      const auto path = straight_path(scene.robot, scene.T_F_T, start, T_R_T_goal);
      if (path && comes_away(checker, *path)) return path;
    }
  return std::nullopt;
}

}  // namespace stonestack::motion
