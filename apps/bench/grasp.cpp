// Prints how often a stone can be grasped where it lies and set on a tower, and what planning it costs.
// Loose stones lie in the field in poses of rest; the tower is another stone at the site with, on top, the
// target: the stone as it lies, turned about the vertical ("turned"), or in another pose of rest ("tipped").
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <numbers>
#include <vector>

#include "bench.hpp"
#include "common_options.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/motion/grasp_check.hpp"
#include "stonestack/motion/regrasp.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack::apps {
namespace {

/// Height of the centre of mass over the lowest point, m.
double standing_height(const Stone& stone, const Eigen::Quaterniond& R_W_O) {
  double lowest = 0.0;
  for (const Eigen::Vector3d& p : stone.mesh.vertices)
    lowest = std::min(lowest, (R_W_O * (p - stone.mass.p_O_M)).z());
  return -lowest;
}

/// A random orientation rolled downhill until the centre of mass is at a local low.
Eigen::Quaterniond rest(const Stone& stone, Random& random) {
  Eigen::Quaterniond R = random.rotation();
  double height = standing_height(stone, R);
  for (double step = 0.3; step > 0.003; step *= 0.93) {
    for (int i = 0; i < 8; ++i) {
      Eigen::Vector3d axis = random.unit_vector();
      axis.z() = 0.0;
      const Eigen::Quaterniond turned(Eigen::AngleAxisd(step, axis.normalized()) * R);
      if (const double h = standing_height(stone, turned); h < height) {
        height = h;
        R = turned;
      }
    }
  }
  return R;
}

Pose standing(const Stone& stone, const Eigen::Quaterniond& R_W_O, const Eigen::Vector2d& at, double z) {
  Pose T = make_pose({at.x(), at.y(), z + standing_height(stone, R_W_O)}, R_W_O);
  T.translation() -= R_W_O * stone.mass.p_O_M;
  return T;
}

/// True if some vertical plane has the two on its two sides, `gap` (m) apart.
bool lie_apart(const SceneObject& a, const SceneObject& b, double gap) {
  constexpr int kDirections = 48;
  const auto along = [](const SceneObject& object, const Eigen::Vector3d& n_W) {
    Eigen::AlignedBox1d range;
    for (const Mesh& piece : object.pieces)
      for (const Eigen::Vector3d& p : piece.vertices)
        range.extend(Eigen::Matrix<double, 1, 1>(n_W.dot(object.T_W_object * p)));
    return range;
  };
  for (int i = 0; i < kDirections; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / kDirections;
    const Eigen::Vector3d n_W(std::cos(turn), std::sin(turn), 0.0);
    if (along(a, n_W).max()(0) + gap < along(b, n_W).min()(0)) return true;
  }
  return false;
}

double top(const SceneObject& object) {
  double z = 0.0;
  for (const Mesh& piece : object.pieces)
    for (const Eigen::Vector3d& p : piece.vertices) z = std::max(z, (object.T_W_object * p).z());
  return z;
}

/// Up to six loose stones and one at the site; object i is loose stone i, the last object is the tower.
struct Problem {
  PlanningScene scene;
  std::vector<int> loose;  ///< index of the stone
};

Problem make_problem(const std::vector<Stone>& stones, Random& random) {
  const CellLayout layout;
  Problem problem;
  problem.scene.robot = read_robot("ur10");
  problem.scene.T_F_T = layout.T_F_T;
  std::vector<int> order(stones.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  random.shuffle(order.begin(), order.end());
  const auto stone = [&](int i) -> const Stone& { return stones[static_cast<std::size_t>(i)]; };
  constexpr double kGap = 0.005;  // m: they lie as they fell, nobody made room for fingers
  for (std::size_t n = 1; n < order.size() && n <= 6; ++n) {
    const Stone& s = stone(order[n]);
    for (int attempt = 0; attempt < 60; ++attempt) {
      const Eigen::Vector2d at(layout.field_centre.x() + layout.field_size.x() * random.uniform(-0.5, 0.5),
                               layout.field_centre.y() + layout.field_size.y() * random.uniform(-0.5, 0.5));
      const SceneObject object{s.name, s.pieces, standing(s, rest(s, random), at, 0.0)};
      const auto& others = problem.scene.objects;
      if (!std::all_of(others.begin(), others.end(),
                       [&](const SceneObject& other) { return lie_apart(object, other, kGap); }))
        continue;
      problem.scene.objects.push_back(object);
      problem.loose.push_back(order[n]);
      break;
    }
  }
  const Stone& base = stone(order[0]);
  problem.scene.objects.push_back(
      {base.name, base.pieces, standing(base, rest(base, random), layout.site, 0.0)});
  return problem;
}

constexpr double kQuickMs = 300.0;  // the mark for a plan

struct Tally {
  int tasks = 0, graspable = 0, planned = 0, quick = 0, turned_over = 0;
  std::vector<double> check_ms, plan_ms, motion_s, regrasp_ms;
  std::array<long, kGraspFaults> refused{};  ///< grasps of all tasks, by test
  long grasps = 0;
  std::map<std::string, int> reasons;
};

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

void print(const char* name, const Tally& t) {
  const auto share = [&](int count) { return 100.0 * count / std::max(1, t.tasks); };
  std::printf(
      "%-7s %3d tasks  grasp %5.1f %%  planned %5.1f %%, within %.0f ms %5.1f %%, with regrasp %5.1f %%  "
      "check "
      "ms %.1f / %.1f  plan ms %.0f / %.0f  regrasp ms %.0f / %.0f  motion s %.1f / %.1f  (median / 95 %%)\n",
      name, t.tasks, share(t.graspable), share(t.planned), kQuickMs, share(t.quick),
      share(t.planned + t.turned_over), quantile(t.check_ms, 0.5), quantile(t.check_ms, 0.95),
      quantile(t.plan_ms, 0.5), quantile(t.plan_ms, 0.95), quantile(t.regrasp_ms, 0.5),
      quantile(t.regrasp_ms, 0.95), quantile(t.motion_s, 0.5), quantile(t.motion_s, 0.95));
  std::printf("    of %ld grasps", t.grasps);
  for (std::size_t i = 0; i < kGraspFaults; ++i)
    std::printf("%s %.1f %% %s", i == 0 ? "" : ",",
                100.0 * static_cast<double>(t.refused[i]) / static_cast<double>(std::max(1L, t.grasps)),
                to_text(static_cast<GraspFault>(i)));
  std::printf("\n");
  for (const auto& [reason, count] : t.reasons) std::printf("    %3d  %s\n", count, reason.c_str());
}

void run_task(const Problem& problem, std::size_t i, const Stone& stone, const Pose& T_W_O_place,
              Tally& tally) {
  PickAndPlaceTask task;
  task.stone = &stone;
  task.object = static_cast<int>(i);
  task.support = static_cast<int>(problem.scene.objects.size()) - 1;
  task.T_W_O_pick = problem.scene.objects[i].T_W_object;
  task.T_W_O_place = T_W_O_place;
  task.q_start << 0.0, -1.8, 1.8, -1.57, -1.57, 0.0;
  ++tally.tasks;
  const Stopwatch check;
  const bool graspable = can_grasp(problem.scene, task);
  tally.check_ms.push_back(1e3 * check.seconds());
  tally.graspable += graspable ? 1 : 0;
  const GraspCheck all = check_grasps(problem.scene, task);
  tally.grasps += all.total;
  for (std::size_t k = 0; k < kGraspFaults; ++k) tally.refused[k] += all.refused[k];
  const Stopwatch plan_time;
  const PickAndPlacePlan plan = plan_pick_and_place(problem.scene, task);
  tally.plan_ms.push_back(1e3 * plan_time.seconds());
  if (plan.status == PickAndPlacePlan::Status::kPlanned) {
    ++tally.planned;
    tally.quick += tally.plan_ms.back() <= kQuickMs ? 1 : 0;
    tally.motion_s.push_back(plan.seconds);
    return;
  }
  if (!all.usable.empty()) ++tally.reasons[plan.reason];  // the others fell to the tests that are counted
  const Stopwatch regrasp_time;
  tally.turned_over += plan_regrasp(problem.scene, task).planned ? 1 : 0;
  tally.regrasp_ms.push_back(1e3 * regrasp_time.seconds());
}

void measure(const std::vector<Stone>& stones, int tasks, std::uint64_t seed) {
  const Stopwatch sampling;
  int grasps = 0;
  for (const Stone& stone : stones) {
    const auto set = cached_grasps(stone, make_robotiq_3f());
    std::printf("%-16s %.2f kg  %4zu grasps\n", stone.name.c_str(), stone.mass.mass, set->grasps.size());
    grasps += static_cast<int>(set->grasps.size());
  }
  std::printf("%d grasps of %zu stones sampled in %.1f s\n", grasps, stones.size(), sampling.seconds());
  Tally turned, tipped;
  for (std::uint64_t n = 0; turned.tasks < tasks; ++n) {
    throw_if_interrupted();
    Random random = Random::stream(seed, n);
    const Problem problem = make_problem(stones, random);
    const SceneObject& tower = problem.scene.objects.back();
    const Eigen::Vector2d site = tower.T_W_object.translation().head<2>();
    for (std::size_t i = 0; i < problem.loose.size() && turned.tasks < tasks; ++i) {
      const Stone& stone = stones[static_cast<std::size_t>(problem.loose[i])];
      const Eigen::Quaterniond yaw(Eigen::AngleAxisd(random.uniform(-3.14, 3.14), Eigen::Vector3d::UnitZ()));
      const Eigen::Quaterniond lying(problem.scene.objects[i].T_W_object.linear());
      run_task(problem, i, stone, standing(stone, yaw * lying, site, top(tower)), turned);
      run_task(problem, i, stone, standing(stone, rest(stone, random), site, top(tower)), tipped);
    }
  }
  print("turned", turned);
  print("tipped", tipped);
}

}  // namespace

void add_bench_grasp(CLI::App& bench) {
  struct Command {
    CommonOptions common;
    int tasks = 40;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub =
      bench.add_subcommand("grasp", "How often a stone can be grasped and set on a tower, and the time");
  sub->add_option("--tasks", command->tasks, "Stone and target pairs a kind")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command->common.register_bench(*sub);
  sub->footer("Example:\n  stonestack bench grasp --catalogue rocks --tasks 200");
  sub->callback([command] {
    std::printf("%d tasks a kind, seed %d\n", command->tasks, command->common.seed);
    measure(command->common.read().stones, command->tasks, static_cast<std::uint64_t>(command->common.seed));
  });
}

}  // namespace stonestack::apps
