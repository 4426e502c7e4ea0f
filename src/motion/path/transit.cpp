#include "motion/transit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kinematics/inverse.hpp"
#include "motion/path/round_corners.hpp"
#include "motion/path/rrt_connect.hpp"
#include "motion/path/shorten_path.hpp"
#include "motion/path/tool_speed.hpp"
#include "motion/timing.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::motion {
namespace {

constexpr double kResolution = 0.00001;       // rad: where nothing is nearer than 10 um to the padding, the
                                              // continuous check finds a motion free
constexpr std::size_t kDirectGoals = 16;      // solves most picks
constexpr double kDetour = 1.3;               // a straight motion this much longer than the nearest goal's
constexpr double kDetourMore = 0.3;           // rad, and this, is taken without searching for another path
constexpr std::size_t kMaxGoals = 64;         // nearest ones; further turns of a wrist are never shorter
constexpr double kMotionsPerSecond = 8000.0;  // a low guess: what planning_effort stands for
// Effort is counted in motion checks of trees. Where the path is hardly longer than the straight path to the
// nearest goal there is little to gain; measured (bench motion), effort in proportion to the excess shortens
// the long paths at half the time that equal effort takes.
constexpr long kMaxPerTree = 4000;  // then another tree: some start badly
constexpr long kEffort = 4000;      // after it no further tree is grown once a path is known
// Checks since the last gain, by the relative excess: more than in proportion, for the long ones have most to
// gain and are few.
constexpr double kStalePerExcess = 1500.0, kStalePerSquare = 4500.0;
constexpr double kMinStale = 150.0, kMaxStale = 2000.0;
constexpr double kGain = 0.97;    // a shorter path than that much of the shortest is a gain
constexpr long kMinMotions = 20;  // of a tree, so that it can begin at all
constexpr int kTries = 40;        // trees, most
// Shortcuts by length. Where only samples are looked at, many of them press a path into what samples miss.
constexpr double kRoughShortcuts = 6.0;  // a rad of each tree's path, before the shortest is chosen
constexpr double kShortcuts = 20.0;      // a rad of the chosen path
constexpr double kNear = 0.005;  // rad, of the chosen path's shortcuts: nearer to things they cost more

bool is_inside(const RobotModel& robot, const Joints& q) {
  return (q.array() >= robot.lower.array() - 1e-9).all() && (q.array() <= robot.upper.array() + 1e-9).all();
}

/// The search for one path. Trees are grown with sampled edges, each looking only for shorter paths than
/// those before; the shortest of their paths is repaired where samples missed something, certified and
/// shortened.
class PathSearch {
 public:
  PathSearch(const CollisionChecker& checker, const Joints& start, const JointPath& goals,
             const MotionOptions& options, double first_seconds)
      : checker_(checker),
        start_(start),
        goals_(goals),
        seed_(static_cast<std::uint64_t>(options.seed)),
        max_(motions_in(options.planning_effort)),
        max_first_(motions_in(std::min(first_seconds, options.planning_effort))) {}

  /// `known`: length of a path that is known already; only shorter ones are looked for.
  [[nodiscard]] std::optional<JointPath> shortest(double known) {
    grow(known);
    std::stable_sort(found_.begin(), found_.end(),
                     [](const JointPath& a, const JointPath& b) { return length(a) < length(b); });
    for (const JointPath& rough : found_) {
      Random random = Random::stream(seed_, kTries);
      const JointPath path = repaired(rough, certified_, random);
      if (!path.empty()) return shortened(path, shortcut_, kShortcuts, random);
    }
    return std::isfinite(known) ? std::nullopt : grow_certified();
  }

 private:
  static long motions_in(double seconds) { return std::max(1L, std::lround(seconds * kMotionsPerSecond)); }

  void grow(double known) {
    double best = known;
    long gained = 0;  // checks spent at the last gain
    for (std::uint64_t k = 0; k < kTries; ++k) {
      const long max = std::isfinite(best) ? max_ : max_first_;
      if (used_ >= max) return;
      TreeLimits limits;
      limits.max_motions = std::min(max - used_, kMaxPerTree);
      if (std::isfinite(best)) {
        const long left = std::min(kEffort - used_, patience(best) - (used_ - gained));
        if (left <= 0) return;
        limits.max_motions = std::max(left, kMinMotions);
        limits.longest = best;
      }
      const Tree tree = rrt_connect(checker_, start_, goals_within(best), limits, Random::stream(seed_, k));
      used_ += tree.motions;
      if (tree.path.empty()) continue;
      Random random = Random::stream(seed_, kTries + 1 + k);
      found_.push_back(shortened(without_detours(tree.path, sampled_), sampled_, kRoughShortcuts, random));
      if (length(found_.back()) < kGain * best) gained = used_;
      best = std::min(best, length(found_.back()));
    }
  }

  static JointPath shortened(const JointPath& path, const MotionTest& is_free, double per_rad,
                             Random& random) {
    return shortcut(path, is_free, static_cast<int>(std::lround(per_rad * length(path))), random);
  }

  /// Checks without a gain after which a path of length `best` is assumed to be short.
  [[nodiscard]] long patience(double best) const {
    const double nearest = (goals_.front() - start_).norm();
    const double excess = best / nearest - 1.0;
    return std::lround(
        std::clamp((kStalePerExcess + kStalePerSquare * excess) * excess, kMinStale, kMaxStale));
  }

  /// Where samples do not do: every edge is certified.
  [[nodiscard]] std::optional<JointPath> grow_certified() {
    const TreeLimits limits{kResolution, max_first_, 0.0};
    const Tree tree = rrt_connect(checker_, start_, goals_, limits, Random::stream(seed_, "certified tree"));
    if (tree.path.empty()) return std::nullopt;
    Random random = Random::stream(seed_, "certified path");
    return shortened(without_detours(tree.path, certified_), shortcut_, kShortcuts, random);
  }

  /// The goals, nearest first, that a path shorter than `longest` can reach.
  [[nodiscard]] std::span<const Joints> goals_within(double longest) const {
    const auto end = std::find_if(goals_.begin() + 1, goals_.end(),
                                  [&](const Joints& goal) { return (goal - start_).norm() >= longest; });
    return {goals_.begin(), end};
  }

  MotionTest certified(double resolution) {
    return [this, resolution](const Joints& a, const Joints& b) {
      return is_inside(checker_.robot(), b) && checker_.motion_is_free(a, b, resolution);
    };
  }

  const CollisionChecker& checker_;
  const Joints start_;
  const JointPath& goals_;
  std::uint64_t seed_;
  long max_;        ///< motion checks
  long max_first_;  ///< until there is a path
  long used_ = 0;
  std::vector<JointPath> found_;
  MotionTest sampled_ = [this](const Joints& a, const Joints& b) { return checker_.samples_are_free(a, b); };
  MotionTest certified_ = certified(kResolution), shortcut_ = certified(kNear);
};

/// Goals within limits that do not collide, nearest first.
JointPath free_goals(const CollisionChecker& checker, const Joints& start, std::span<const Joints> goals) {
  const RobotModel& robot = checker.robot();
  JointPath sorted;
  for (const auto& goal : goals) {
    require(goal.allFinite(), "a goal has the joint angles ", goal.transpose());
    if (is_inside(robot, goal)) sorted.push_back(goal);
  }
  std::stable_sort(sorted.begin(), sorted.end(), [&](const Joints& a, const Joints& b) {
    return (a - start).squaredNorm() < (b - start).squaredNorm();
  });
  JointPath free;
  for (const auto& goal : sorted) {
    if (free.size() == kMaxGoals) break;
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

/// Path and time law with the gripper empty and as wide open as in the scene. Corners are cut only where
/// that keeps the padding with which the path was found.
std::optional<JointTrajectory> plan(const PlanningScene& scene, const Joints& start,
                                    std::span<const Joints> goals, const MotionOptions& options) {
  TimingLimits limits = timing_limits(scene.robot, options);
  for (const double padding : {options.transit_padding, options.approach_padding}) {
    CollisionRules rules;
    rules.padding = std::min(padding, options.transit_padding);
    rules.self_padding = std::min(rules.self_padding, padding);
    rules.opening = scene.opening;
    const CollisionChecker checker(scene, rules);
    const auto path = find_path(checker, start, goals, options);
    if (!path) continue;
    limits.blend = free_blend(checker, *path, limits);
    return time_path(*path, limits, scene.robot, scene.T_F_T, transit_speed(scene, options));
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
                                   std::span<const Joints> goals, const MotionOptions& options,
                                   double first_seconds) {
  require(start.allFinite(), "the start has the joint angles ", start.transpose());
  if (checker.collides(start)) return std::nullopt;
  const JointPath free = free_goals(checker, start, goals);
  if (free.empty()) return std::nullopt;
  if (free.front() == start) return JointPath{start};
  auto best = direct(checker, start, free);
  const double nearest = (free.front() - start).norm();
  if (best && length(*best) <= kDetour * nearest + kDetourMore) return best;
  // A straight motion to a far branch may be much longer than a detour to a near one.
  const double known = best ? length(*best) : std::numeric_limits<double>::infinity();
  if (auto path = PathSearch(checker, start, free, options, first_seconds).shortest(known))
    if (!best || length(*path) < known) best = std::move(path);
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

}  // namespace stonestack::motion
