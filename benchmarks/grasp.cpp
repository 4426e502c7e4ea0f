// Prints how often a stone can be grasped where it lies and set on a tower, and what planning it costs.
// Loose stones lie in the field in resting poses; the tower is another stone at the site with, on top, the
// target: the stone as it lies, turned about the vertical ("turned"), or in another resting pose ("tipped").
// Tipped targets are also listed by the angle between the stone's ups at both ends, beside what the gripper
// alone (no arm) could do: a grasp that the table forbids at one end helps no planner.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <vector>

#include "bench.hpp"
#include "common_options.hpp"
#include "core/quantile.hpp"
#include "grasp_problems.hpp"
#include "motion/grasp_check.hpp"
#include "motion/regrasp.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::bench {
namespace {

constexpr double kQuickMs = 300.0;  // the mark for a plan
constexpr std::size_t kAngles = 6;  // ranges of 30 deg

/// How tasks of one range of angles went.
struct AngleTally {
  int tasks = 0, gripper = 0, planned = 0, once = 0, twice = 0;
};

struct Tally {
  int tasks = 0, graspable = 0, planned = 0, quick = 0, quick_with = 0;
  std::array<int, 4> set_down{};  ///< plans with that many set-downs
  std::array<AngleTally, kAngles> angles{};
  std::vector<double> check_ms, plan_ms, motion_s, regrasp_ms;
  std::vector<double> tilts;  ///< tilt beyond which a stone topples that is set down in between, rad
  std::array<long, kGraspFaults> refused{};  ///< grasps of all tasks, by test
  long grasps = 0;
  std::map<std::string, int> reasons;
};

double processor_ms() {
  return 1e3 * processor_seconds();
}

double share_of(int count, const Tally& t) {
  return 100.0 * count / std::max(1, t.tasks);
}

void report(const std::vector<std::pair<const char*, const Tally*>>& kinds, Results& results) {
  results.table("tasks", {{"target"},
                          {"tasks"},
                          {"graspable_percent", 1},
                          {"planned_percent", 1},
                          {"quick_percent", 1},
                          {"with_regrasp_percent", 1},
                          {"once"},
                          {"twice"},
                          {"all_quick_percent", 1}});
  for (const auto& [name, t] : kinds)
    results.row({name, t->tasks, share_of(t->graspable, *t), share_of(t->planned, *t), share_of(t->quick, *t),
                 share_of(t->planned + t->set_down[1] + t->set_down[2], *t), t->set_down[1], t->set_down[2],
                 share_of(t->quick_with, *t)});
  results.table("times", {{"target"},
                          {"check_ms_median", 1},
                          {"check_ms_p95", 1},
                          {"plan_ms_median", 0},
                          {"plan_ms_p95", 0},
                          {"regrasp_ms_median", 0},
                          {"regrasp_ms_p95", 0},
                          {"motion_s_median", 1},
                          {"motion_s_p95", 1}});
  for (const auto& [name, t] : kinds)
    results.row({name, quantile(t->check_ms, 0.5), quantile(t->check_ms, 0.95), quantile(t->plan_ms, 0.5),
                 quantile(t->plan_ms, 0.95), quantile(t->regrasp_ms, 0.5), quantile(t->regrasp_ms, 0.95),
                 quantile(t->motion_s, 0.5), quantile(t->motion_s, 0.95)});
  results.table("tilt at which a stone that was set down topples",
                {{"target"}, {"deg_min", 1}, {"deg_p10", 1}, {"deg_median", 1}});
  for (const auto& [name, t] : kinds)
    results.row({name, quantile(t->tilts, 0.0) * 180.0 / M_PI, quantile(t->tilts, 0.1) * 180.0 / M_PI,
                 quantile(t->tilts, 0.5) * 180.0 / M_PI});
  results.table("grasps", {{"target"}, {"fault"}, {"percent", 1}, {"grasps"}});
  for (const auto& [name, t] : kinds)
    for (std::size_t i = 0; i < kGraspFaults; ++i)
      results.row({name, to_text(static_cast<GraspFault>(i)),
                   100.0 * static_cast<double>(t->refused[i]) / static_cast<double>(std::max(1L, t->grasps)),
                   t->grasps});
  results.table("why tasks failed", {{"target"}, {"tasks"}, {"reason"}});
  for (const auto& [name, t] : kinds)
    for (const auto& [reason, count] : t->reasons) results.row({name, count, reason});
}

void report_angles(const Tally& t, Results& results) {
  results.table(
      "tipped, by the angle between ups",
      {{"from_deg"}, {"to_deg"}, {"tasks"}, {"gripper_alone"}, {"planned"}, {"once"}, {"twice"}, {"none"}});
  for (std::size_t i = 0; i < kAngles; ++i) {
    const AngleTally& a = t.angles[i];
    results.row({30 * i, 30 * (i + 1), a.tasks, a.gripper, a.planned, a.once, a.twice,
                 a.tasks - a.planned - a.once - a.twice});
  }
}

/// Angle between the directions of the stone that are up before and after, rad.
double between_ups(const PickAndPlaceTask& task) {
  const double c = task.T_W_O_pick.linear().row(2).dot(task.T_W_O_place.linear().row(2));
  return std::acos(std::clamp(c, -1.0, 1.0));
}

void run_task(const PlanningScene& scene, const PickAndPlaceTask& task, const MotionOptions& options,
              Tally& tally) {
  AngleTally& angle =
      tally.angles[std::min(kAngles - 1, static_cast<std::size_t>(6.0 * between_ups(task) / M_PI))];
  ++tally.tasks;
  ++angle.tasks;
  angle.gripper += gripper_can_grasp(scene, task, options) ? 1 : 0;
  const double check = processor_ms();
  const bool graspable = can_grasp(scene, task, options);
  tally.check_ms.push_back(processor_ms() - check);
  tally.graspable += graspable ? 1 : 0;
  const GraspCheck all = check_grasps(scene, task, options);
  tally.grasps += all.total;
  for (std::size_t k = 0; k < kGraspFaults; ++k) tally.refused[k] += all.refused[k];
  const double plan_time = processor_ms();
  const PickAndPlacePlan plan = plan_pick_and_place(scene, task, options);
  tally.plan_ms.push_back(processor_ms() - plan_time);
  if (plan.status == PickAndPlacePlan::Status::kPlanned) {
    ++tally.planned;
    ++angle.planned;
    tally.quick += tally.plan_ms.back() <= kQuickMs ? 1 : 0;
    tally.quick_with += tally.plan_ms.back() <= kQuickMs ? 1 : 0;
    tally.motion_s.push_back(plan.seconds);
    return;
  }
  const double regrasp_time = processor_ms();
  const RegraspPlan regrasp = plan_regrasp(scene, task, options);
  tally.regrasp_ms.push_back(processor_ms() - regrasp_time);
  if (!regrasp.planned) {
    ++tally.reasons[regrasp.reason];
    return;
  }
  tally.tilts.insert(tally.tilts.end(), regrasp.tilts.begin(), regrasp.tilts.end());
  const std::size_t stops = regrasp.T_W_O_between.size();
  ++tally.set_down[std::min<std::size_t>(stops, 2)];
  ++(stops == 1 ? angle.once : angle.twice);
  tally.quick_with += tally.plan_ms.back() + tally.regrasp_ms.back() <= kQuickMs ? 1 : 0;
}

void sample_grasps(const std::vector<Stone>& stones, Results& results) {
  const double sampling = processor_ms();
  std::size_t grasps = 0;
  results.table("stones", {{"stone"}, {"x_mm", 0}, {"y_mm", 0}, {"z_mm", 0}, {"mass_kg"}, {"grasps"}});
  for (const Stone& stone : stones) {
    const auto set = cached_grasps(stone, make_robotiq_3f());
    const Eigen::Vector3d size = bounds(stone.scan).sizes();
    results.row(
        {stone.name, 1e3 * size.x(), 1e3 * size.y(), 1e3 * size.z(), stone.mass.mass, set->grasps.size()});
    grasps += set->grasps.size();
  }
  results.figures(
      "sampling",
      {{"stones", stones.size()}, {"grasps", grasps}, {"cpu_s", 1e-3 * (processor_ms() - sampling), 1}});
}

void measure(const std::vector<Stone>& stones, int tasks, std::uint64_t seed, const MotionOptions& options,
             Results& results) {
  sample_grasps(stones, results);
  Tally turned, tipped;
  for (std::uint64_t n = 0; turned.tasks < tasks; ++n) {
    throw_if_interrupted();
    Random random = Random::stream(seed, n);
    const GraspProblem problem = make_grasp_problem(stones, random);
    const SceneObject& tower = problem.scene.objects.back();
    const Eigen::Vector2d site = tower.T_W_object.translation().head<2>();
    for (std::size_t i = 0; i < problem.loose.size() && turned.tasks < tasks; ++i) {
      const Stone& stone = at(stones, problem.loose[i]);
      PickAndPlaceTask task;
      task.stone = &stone;
      task.object = static_cast<int>(i);
      task.support = static_cast<int>(problem.scene.objects.size()) - 1;
      task.T_W_O_pick = problem.scene.objects[i].T_W_object;
      task.q_start << 0.0, -1.8, 1.8, -1.57, -1.57, 0.0;
      const Eigen::Quaterniond yaw(Eigen::AngleAxisd(random.uniform(-3.14, 3.14), Eigen::Vector3d::UnitZ()));
      const Eigen::Quaterniond lying(task.T_W_O_pick.linear());
      task.T_W_O_place = standing_at(stone, yaw * lying, site, top(tower));
      run_task(problem.scene, task, options, turned);
      task.T_W_O_place = standing_at(stone, rest(stone, random), site, top(tower));
      run_task(problem.scene, task, options, tipped);
    }
  }
  report({{"turned", &turned}, {"tipped", &tipped}}, results);
  report_angles(tipped, results);
}

}  // namespace

void add_grasp(CLI::App& app) {
  struct Command {
    CommonOptions common;
    int tasks = 40;
    int generated = 0;
    MotionOptions motion;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub =
      app.add_subcommand("grasp", "How often a stone can be grasped and set on a tower, and the time");
  sub->add_option("--tasks", command->tasks, "Stone and target pairs a kind")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  sub->add_option("--generated", command->generated,
                  "That many limestones of 7 to 14 cm made from the seed, instead of a catalogue")
      ->check(CLI::Range(7, 1000));
  command->common.register_draw(*sub);
  sub->footer(
      "Examples:\n  stonestack-bench grasp --generated 12 --tasks 200\n"
      "  stonestack-bench grasp --catalogue rocks --tasks 200");
  measure_by(*sub, [command](Results& results) {
    command->common.settings.apply(nest("motion", fields(command->motion)));
    const auto seed = static_cast<std::uint64_t>(command->common.seed);
    results.settings({{"tasks", command->tasks},
                      {"generated", command->generated},
                      {"quick_ms", kQuickMs},
                      {"seed", command->common.seed}});
    if (command->generated == 0)
      return measure(command->common.read().stones, command->tasks, seed, command->motion, results);
    measure(random_stones(seed, command->generated), command->tasks, seed, command->motion, results);
  });
}

}  // namespace stonestack::bench
