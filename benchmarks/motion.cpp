// Prints the speed of collision checks and transits. Times are processor time; seeds are fixed.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "bench.hpp"
#include "core/constants.hpp"
#include "core/quantile.hpp"
#include "kinematics/inverse.hpp"
#include "motion/problem_file.hpp"
#include "motion/transit.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/hardware/cell.hpp"

namespace stonestack::bench {
namespace {

constexpr double kLong = 1.2;  // times the shortest path that is known

SceneObject object(const std::string& name, const Mesh& mesh, const Pose& T_W_object) {
  return {name, {mesh}, T_W_object};
}

PlanningScene ur10_scene() {
  PlanningScene scene;
  scene.robot = read_robot("ur10");
  scene.T_F_T = CellLayout().T_F_T;
  return scene;
}

/// Thirteen stones: some stacked, the others around.
PlanningScene thirteen_loose_objects(std::uint64_t seed) {
  PlanningScene scene = ur10_scene();
  Random random = Random::stream(seed, "thirteen objects");
  for (int i = 0; i < 13; ++i) {
    const Eigen::Vector3d p =
        i < 5 ? Eigen::Vector3d(0.7, 0.28, 0.05 + 0.1 * i)
              : Eigen::Vector3d(random.uniform(0.5, 0.9), random.uniform(-0.43, 0.07), 0.05);
    scene.objects.push_back(object("stone", make_sphere(0.06, 1), make_pose(p, random.rotation())));
  }
  return scene;
}

/// Two towers, a post and two bars between loose stones and site, 4 cm apart from the shortest paths.
PlanningScene hard_scene() {
  PlanningScene scene = ur10_scene();
  const auto box = [&](const char* name, const Eigen::Vector3d& size, const Eigen::Vector3d& p) {
    scene.objects.push_back(object(name, make_box(size), make_pose(p)));
  };
  box("first tower", {0.14, 0.14, 0.45}, {0.62, 0.05, 0.225});
  box("second tower", {0.14, 0.14, 0.45}, {0.90, 0.05, 0.225});
  box("post", {0.05, 0.05, 1.2}, {0.50, -0.45, 0.6});
  box("lower bar", {1.2, 0.04, 0.04}, {0.75, 0.05, 0.60});
  box("upper bar", {1.2, 0.04, 0.04}, {0.75, 0.05, 1.10});
  return scene;
}

std::vector<Joints> tool_down_at(const PlanningScene& scene, const Eigen::Vector3d& p_W_tip, double turn) {
  Pose T_W_T = Pose::Identity();
  T_W_T.linear() =
      (Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  T_W_T.translation() = p_W_tip;
  Joints seed;
  seed << 0, -0.5 * kPi, 0.5 * kPi, -0.5 * kPi, -0.5 * kPi, 0;
  std::vector<Joints> all;
  for (const auto& s : inverse(scene.robot, T_W_T * scene.T_F_T.inverse(), seed)) all.push_back(s.q);
  return all;
}

void measure_collision(std::uint64_t seed, Results& results) {
  results.table("collision checks among 13 objects",
                {{"configurations"}, {"checks_per_s", 0}, {"collide_percent", 1}});
  const CollisionChecker checker(thirteen_loose_objects(seed));
  Random random = Random::stream(seed, "configurations");
  std::vector<Joints> anywhere(50000), working;
  for (auto& q : anywhere)
    for (auto& angle : q) angle = random.uniform(-kPi, kPi);
  for (const auto& q : anywhere)
    if (!checker.collides(q)) working.push_back(q);
  for (const auto* set : {&anywhere, &working}) {
    const double start = processor_seconds();
    std::size_t hits = 0;
    for (const auto& q : *set) hits += checker.collides(q) ? 1 : 0;
    const double seconds = processor_seconds() - start;
    results.row({set == &anywhere ? "random" : "free ones", static_cast<double>(set->size()) / seconds,
                 100.0 * static_cast<double>(hits) / static_cast<double>(set->size())});
  }
}

void measure_transit(int problems, std::uint64_t seed, Results& results) {
  const PlanningScene scene = hard_scene();
  const CollisionChecker checker(scene);
  Random random = Random::stream(seed, "transit problems");
  std::vector<double> milliseconds, ratios;
  int solved = 0, straight = 0, posed = 0;
  while (posed < problems) {
    const auto place = [&](double low, double high) {
      return Eigen::Vector3d(random.uniform(0.55, 0.95), random.uniform(low, high), random.uniform(0.1, 0.3));
    };
    const auto starts = tool_down_at(scene, place(-0.45, -0.2), random.uniform(-kPi, kPi));
    const auto goals = tool_down_at(scene, place(0.3, 0.5), random.uniform(-kPi, kPi));
    if (starts.empty() || checker.collides(starts.front())) continue;
    if (std::all_of(goals.begin(), goals.end(), [&](const Joints& q) { return checker.collides(q); }))
      continue;
    ++posed;
    const double start = processor_seconds();
    const auto path = find_path(checker, starts.front(), goals);
    milliseconds.push_back(1e3 * (processor_seconds() - start));
    if (!path) continue;
    ++solved;
    straight += path->size() == 2 ? 1 : 0;
    double best = length(*path);
    for (int k = 2; k <= 8; ++k) {
      MotionOptions options;
      options.seed = k;
      if (const auto other = find_path(checker, starts.front(), goals, options))
        best = std::min(best, length(*other));
    }
    ratios.push_back(best > 0.0 ? length(*path) / best : 1.0);
  }
  const auto long_ones = std::count_if(ratios.begin(), ratios.end(), [](double r) { return r > kLong; });
  results.figures("transits of the hard set", {{"problems", posed},
                                               {"solved", solved},
                                               {"straight", straight},
                                               {"ms_median", quantile(milliseconds, 0.5), 1},
                                               {"ms_p95", quantile(milliseconds, 0.95), 1},
                                               {"ms_max", quantile(milliseconds, 1.0), 1},
                                               {"length_over_best_of_eight_median", quantile(ratios, 0.5)},
                                               {"length_over_best_of_eight_p95", quantile(ratios, 0.95)},
                                               {"length_over_best_of_eight_max", quantile(ratios, 1.0)},
                                               {"longer_than_1.2_times_best", long_ones}});
}

/// "finger and post are 3.1 mm apart": the pair that obstructs a configuration.
std::string nearest(const CollisionChecker& checker, const Joints& q) {
  const Clearance c = checker.clearance(q);
  const auto millimetres = std::round(1e4 * std::abs(c.distance)) / 10;
  return concat(c.first, c.distance < 0 ? " stands in " : " and ", c.second,
                c.distance < 0 ? " by " : " are ", millimetres, c.distance < 0 ? " mm" : " mm apart");
}

/// Why a problem may have no solution, from its ends; empty if they are free.
std::string blocked_ends(const CollisionChecker& checker, const MotionProblem& problem) {
  if (checker.collides(problem.start)) return concat("the start collides: ", nearest(checker, problem.start));
  if (std::any_of(problem.goals.begin(), problem.goals.end(),
                  [&](const Joints& goal) { return !checker.collides(goal); }))
    return {};
  std::string text;
  for (std::size_t k = 0; k < problem.goals.size(); ++k)
    text +=
        concat(text.empty() ? "" : "; ", "goal ", k + 1, " collides: ", nearest(checker, problem.goals[k]));
  return text;
}

/// Problems of a file, each from start to any of its goals.
void plan_file(const std::string& path, Results& results) {
  const MotionProblems file = read_motion_problems(path);
  CollisionRules rules;
  rules.padding = file.padding;
  rules.opening = file.scene.gripper.max_opening;
  const CollisionChecker checker(file.scene, rules);
  std::size_t solved = 0;
  results.settings({{"file", path}, {"padding_mm", 1e3 * file.padding}});
  results.table("problems",
                {{"problem"}, {"solved"}, {"waypoints"}, {"length_rad"}, {"ms", 1}, {"blocked_ends"}});
  std::vector<double> milliseconds;
  for (std::size_t i = 0; i < file.problems.size(); ++i) {
    const MotionProblem& problem = file.problems[i];
    const double start = processor_seconds();
    const auto path_found = find_path(checker, problem.start, problem.goals);
    milliseconds.push_back(1e3 * (processor_seconds() - start));
    solved += path_found ? 1 : 0;
    if (path_found)
      results.row({i + 1, true, path_found->size(), length(*path_found), milliseconds.back(), TableValue()});
    else
      results.row(
          {i + 1, false, TableValue(), TableValue(), milliseconds.back(), blocked_ends(checker, problem)});
  }
  results.figures("all", {{"problems", file.problems.size()},
                          {"solved", solved},
                          {"ms_median", quantile(milliseconds, 0.5), 1},
                          {"ms_p95", quantile(milliseconds, 0.95), 1},
                          {"ms_max", quantile(milliseconds, 1.0), 1}});
  if (solved < file.problems.size())
    throw Error(concat(path, ": ", file.problems.size() - solved, " of ", file.problems.size(),
                       " problems were not solved"),
                ExitCode::kExecutionFailed);
}

}  // namespace

void add_motion(CLI::App& app) {
  struct Command {
    int problems = 100;
    int seed = 1;
    std::string file;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand("motion", "Collision checks a second; transits on a hard set");
  sub->add_option("--problems", command->problems, "Transit problems")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  sub->add_option("--seed", command->seed)->check(CLI::Range(0, 2147483647))->capture_default_str();
  sub->add_option("--file", command->file,
                  "Plan the problems of this file instead (docs/formats.md, Motion problems)");
  sub->footer(
      "Examples:\n  stonestack-bench motion --problems 500\n  stonestack-bench motion --file post.txt");
  measure_by(*sub, [command](Results& results) {
    if (!command->file.empty()) return plan_file(command->file, results);
    results.settings({{"problems", command->problems}, {"seed", command->seed}});
    measure_collision(static_cast<std::uint64_t>(command->seed), results);
    measure_transit(command->problems, static_cast<std::uint64_t>(command->seed), results);
  });
}

}  // namespace stonestack::bench
