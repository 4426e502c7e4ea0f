#include "stonestack/motion/transit.hpp"

#include <algorithm>
#include <cmath>

#include "motion/rrt_connect.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/inverse.hpp"
#include "stonestack/motion/timing.hpp"

namespace stonestack {
namespace {

constexpr double kResolution = 0.001;         // rad: facts ask for 0.005; finer costs little and is proven
constexpr std::size_t kDirectGoals = 16;      // facts: solves most picks
constexpr double kDetour = 1.3;               // a straight motion this much longer than the nearest goal's
constexpr double kDetourMore = 0.3;           // rad, and this, is taken without looking for another way
constexpr std::size_t kMostGoals = 64;        // nearest ones; further turns of a wrist are never shorter
constexpr int kTries = 3;                     // trees grown; the shortest result is kept
constexpr int kShortcuts = 60;                // attempts a path
constexpr double kMotionsPerSecond = 4000.0;  // measured: motion checks of a tree in clutter

/// Removes way points that are not needed, then replaces pieces between random points by straight ones.
JointPath shortened(const CollisionChecker& checker, JointPath path, Random& random) {
  for (std::size_t i = 0; i + 2 < path.size(); ++i) {
    std::size_t next = path.size() - 1;
    while (next > i + 1 && !checker.motion_is_free(path[i], path[next], kResolution)) --next;
    path.erase(path.begin() + static_cast<std::ptrdiff_t>(i) + 1,
               path.begin() + static_cast<std::ptrdiff_t>(next));
  }
  for (int k = 0; k < kShortcuts && path.size() > 2; ++k) {
    throw_if_interrupted();
    std::vector<double> at(path.size(), 0.0);
    for (std::size_t i = 1; i < path.size(); ++i) at[i] = at[i - 1] + (path[i] - path[i - 1]).norm();
    double from = random.uniform(0.0, at.back());
    double to = random.uniform(0.0, at.back());
    if (from > to) std::swap(from, to);
    const auto piece_of = [&](double s) {
      const auto after = std::upper_bound(at.begin() + 1, at.end() - 1, s);
      return static_cast<std::size_t>(after - at.begin()) - 1;
    };
    const std::size_t first = piece_of(from), last = piece_of(to);
    if (first == last) continue;
    const auto point = [&](std::size_t piece, double s) -> Joints {
      const double span = at[piece + 1] - at[piece];
      return span > 0 ? Joints(path[piece] + (path[piece + 1] - path[piece]) * ((s - at[piece]) / span))
                      : path[piece];
    };
    const Joints a = point(first, from), b = point(last, to);
    if ((b - a).norm() > to - from - 1e-6 || !checker.motion_is_free(a, b, kResolution)) continue;
    JointPath next(path.begin(), path.begin() + static_cast<std::ptrdiff_t>(first) + 1);
    next.push_back(a);
    next.push_back(b);
    next.insert(next.end(), path.begin() + static_cast<std::ptrdiff_t>(last) + 1, path.end());
    path = std::move(next);
  }
  return path;
}

bool is_certified(const CollisionChecker& checker, const JointPath& path) {
  for (std::size_t i = 1; i < path.size(); ++i)
    if (!checker.motion_is_free(path[i - 1], path[i], kResolution)) return false;
  return true;
}

/// One tree's path, shortened and certified. Most edges of a tree are never part of a path, so at first they
/// are only sampled; where the path turns out not to be free, a tree of certified edges is grown.
std::optional<JointPath> grown(const CollisionChecker& checker, const Joints& start, const JointPath& goals,
                               long most_motions, const MotionOptions& options, std::uint64_t task) {
  const auto seed = static_cast<std::uint64_t>(options.seed);
  for (const double resolution : {0.0, kResolution}) {
    const auto found =
        rrt_connect(checker, start, goals, resolution, most_motions, Random::stream(seed, task));
    if (!found) return std::nullopt;
    Random random = Random::stream(seed, task + kTries);
    JointPath path = shortened(checker, *found, random);
    if (is_certified(checker, path)) return path;
  }
  return std::nullopt;
}

/// Goals within limits that do not collide, nearest first.
JointPath free_goals(const CollisionChecker& checker, const Joints& start, std::span<const Joints> goals) {
  const RobotModel& robot = checker.robot();
  JointPath sorted;
  for (const auto& goal : goals) {
    require(goal.allFinite(), "a goal has the joint angles ", goal.transpose());
    if ((goal.array() >= robot.lower.array() - 1e-9).all() &&
        (goal.array() <= robot.upper.array() + 1e-9).all())
      sorted.push_back(goal);
  }
  std::stable_sort(sorted.begin(), sorted.end(), [&](const Joints& a, const Joints& b) {
    return (a - start).squaredNorm() < (b - start).squaredNorm();
  });
  JointPath free;
  for (const auto& goal : sorted) {
    if (free.size() == kMostGoals) break;
    if (!checker.collides(goal)) free.push_back(goal);
  }
  return free;
}

/// The straight motion to the first goal that has one.
std::optional<JointPath> direct(const CollisionChecker& checker, const Joints& start,
                                const JointPath& goals) {
  for (std::size_t i = 0; i < std::min(kDirectGoals, goals.size()); ++i)
    if (checker.motion_is_free(start, goals[i], kResolution)) return JointPath{start, goals[i]};
  return std::nullopt;
}

/// Path and time law with the hand empty and open.
std::optional<JointTrajectory> plan(const PlanningScene& scene, const Joints& start,
                                    std::span<const Joints> goals, const MotionOptions& options) {
  for (const double padding : {options.transit_padding, options.approach_padding}) {
    CollisionRules rules;
    rules.padding = std::min(padding, options.transit_padding);
    rules.self_padding = std::min(rules.self_padding, padding);
    rules.opening = scene.gripper.largest_opening;
    if (const auto path = find_path(CollisionChecker(scene, rules), start, goals, options))
      return time_path(*path, timing_limits(scene.robot, options));
  }
  return std::nullopt;
}

}  // namespace

double length(const JointPath& path) {
  double sum = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) sum += (path[i] - path[i - 1]).norm();
  return sum;
}

std::optional<JointPath> find_path(const CollisionChecker& checker, const Joints& start,
                                   std::span<const Joints> goals, const MotionOptions& options) {
  require(start.allFinite(), "the start has the joint angles ", start.transpose());
  if (checker.collides(start)) return std::nullopt;
  const JointPath free = free_goals(checker, start, goals);
  if (free.empty()) return std::nullopt;
  if (free.front() == start) return JointPath{start};
  auto best = direct(checker, start, free);
  const double nearest = (free.front() - start).norm();
  if (best && length(*best) <= kDetour * nearest + kDetourMore) return best;
  // A straight motion to a far branch may be much longer than a way around to a near one.
  const long most = std::max(10L, std::lround(options.planning_seconds * kMotionsPerSecond / kTries));
  for (int k = 0; k < kTries; ++k) {
    if (auto path = grown(checker, start, free, most, options, static_cast<std::uint64_t>(k)))
      if (!best || length(*path) < length(*best)) best = std::move(path);
  }
  return best;
}

std::optional<JointTrajectory> plan_transit(const PlanningScene& scene, const Joints& q_start,
                                            const Joints& q_goal, const MotionOptions& options) {
  return plan(scene, q_start, std::span(&q_goal, 1), options);
}

std::optional<JointTrajectory> plan_transit(const PlanningScene& scene, const Joints& q_start,
                                            const Pose& T_W_F_goal, const MotionOptions& options) {
  JointPath goals;
  for (const auto& solution : inverse(scene.robot, scene.T_W_R.inverse() * T_W_F_goal, q_start))
    goals.push_back(solution.q);
  return plan(scene, q_start, goals, options);
}

}  // namespace stonestack
