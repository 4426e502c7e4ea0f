// Prints how well the gripper holds what it lifts: every stone of a catalogue lies somewhere, is grasped
// where the planner says, lifted and carried above the site; the true stone's motion in the gripper is looked
// at.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "bench.hpp"
#include "common_options.hpp"
#include "core/constants.hpp"
#include "core/quantile.hpp"
#include "grasp_problems.hpp"
#include "motion/grasp/pad_press.hpp"
#include "stacking/execute.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/observe.hpp"
#include "stonestack/stone/catalogue.hpp"
#include "view_error.hpp"

namespace stonestack::bench {
namespace {

constexpr double kSlid = 0.005;          // m in the gripper: more spoils the placement
constexpr double kTurned = 3 * kDegree;  // the same
constexpr double kLost = 0.05;           // m: not in the gripper any more
constexpr double kHeight = 0.15;         // m, of the target above the table
constexpr double kSpacing = 0.003;       // m, between samples that pads press on

struct Settings {
  CommonOptions common;
  int generated = 0;
  int picks = 10;
  ViewError view;
  bool every = false;
  bool locked = false;
  bool pads_only = false;
  MotionOptions motion;
  SimulationOptions simulation;
};

/// Outcomes of lifts.
struct HoldTally {
  int tried = 0, no_plan = 0, stopped = 0, not_held = 0, dropped = 0, moved = 0;
  std::vector<double> slide, turn;

  void add(const HoldTally& other) {
    tried += other.tried;
    no_plan += other.no_plan;
    stopped += other.stopped;
    not_held += other.not_held;
    dropped += other.dropped;
    moved += other.moved;
    slide.insert(slide.end(), other.slide.begin(), other.slide.end());
    turn.insert(turn.end(), other.turn.begin(), other.turn.end());
  }
};

/// The grasp of the set that a plan took.
const Grasp* grasp_of(const GraspSet& set, const Pose& T_O_T) {
  for (const Grasp& grasp : set.grasps)
    if (grasp.T_O_T.isApprox(T_O_T, 1e-12)) return &grasp;
  return nullptr;
}

void print_lift(const Stone& stone, const PlanningScene& scene, const PickAndPlacePlan& plan,
                const Pose& T_W_T, const PoseDifference& off, const std::string& what, Results& results) {
  results.note("  %s: %.1f mm %.1f deg, %s", stone.name.c_str(), 1e3 * off.translation, off.angle / kDegree,
               what.c_str());
  const auto set = cached_grasps(stone, scene.gripper);
  if (const Grasp* grasp = grasp_of(*set, plan.T_O_T)) {
    const PadPress press(sample_surface(stone.scan, kSpacing), stone.mass, scene.gripper, *grasp);
    const PadPress::Load load = press.bear(-T_W_T.linear().row(2).transpose(), 4.0);
    results.note(
        "    grasp %td of %zu, score %.2f, fingers %.0f mm apart; pads: bear %.1f weights, move %.2f mm "
        "%.1f deg, %.1f %.1f %.1f mm deep, closing turns %.1f deg",
        grasp - set->grasps.data(), set->grasps.size(), grasp->score, 1e3 * grasp->spacing, load.share,
        1e3 * load.moved, load.turned / kDegree, 1e3 * press.deepest(0), 1e3 * press.deepest(1),
        1e3 * press.deepest(2), press.squeeze_turn() / kDegree);
  }
}

/// Lifts and carries one stone that lies somewhere in a cell of its own.
void lift(const Stone& stone, const Settings& settings, const MotionOptions& options, int seed,
          HoldTally& tally, Results& results) {
  const RobotModel robot = read_robot("ur10");
  CellLayout layout;
  layout.linkage = settings.simulation.linkage;  // as `run` does for a named cell
  Random random = Random::stream(static_cast<std::uint64_t>(seed), "hold " + stone.name);
  SimulationOptions simulation = settings.simulation;
  simulation.seed = seed;
  if (settings.locked) simulation.regrip = false;
  const std::vector<Stone> stones{stone};
  SimulatedCell simulated(stones, {0_stone}, robot, layout, simulation);
  Cell cell = simulated.cell();

  PickAndPlaceTask task;
  task.stone = &stone;
  task.object = 0;
  task.T_W_O_pick = settings.view.estimated(simulated.truth().T_W_O[0], random);
  task.T_W_O_place = task.T_W_O_pick;
  task.T_W_O_place.prerotate(
      Eigen::AngleAxisd(random.uniform(-std::numbers::pi, std::numbers::pi), Eigen::Vector3d::UnitZ()));
  task.T_W_O_place.translation() << layout.site, task.T_W_O_pick.translation().z() + kHeight;
  task.q_start = cell.arm.state().q;
  PlanningScene scene;
  scene.robot = robot;
  scene.T_W_R = layout.T_W_R;
  scene.T_F_T = layout.T_F_T;
  scene.gripper = stacking::gripper_of(layout);
  scene.objects.push_back({stone.name, stone.pieces, task.T_W_O_pick});
  ++tally.tried;
  PickAndPlacePlan plan = plan_pick_and_place(scene, task, options);
  if (plan.status != PickAndPlacePlan::Status::kPlanned) {
    ++tally.no_plan;
    if (settings.every) results.note("  %s: %s", stone.name.c_str(), plan.reason.c_str());
    return;
  }
  plan.steps.erase(std::find_if(plan.steps.begin(), plan.steps.end(),
                                [](const PlanStep& step) { return step.kind == PlanStep::Kind::kDescent; }),
                   plan.steps.end());
  ExecutionResult result;
  try {
    result = execute(plan, stone, scene, cell, options, nullptr);
  } catch (const DeviceError& stop) {  // a protective stop
    result = {ExecutionResult::Status::kStopped, 0.0, stop.what()};
  }
  const Pose T_W_T = layout.T_W_R * forward(robot, cell.arm.state().q) * layout.T_F_T;
  const auto off = difference(plan.T_O_T.inverse(), T_W_T.inverse() * simulated.truth().T_W_O[0]);
  std::string what = "held";
  if (result.status == ExecutionResult::Status::kStopped) {
    ++tally.stopped;
    what = result.reason;
  } else if (result.status == ExecutionResult::Status::kLost) {
    ++tally.dropped;
    what = result.reason;
  } else if (result.status != ExecutionResult::Status::kReleased) {
    ++tally.not_held;
    what = result.reason;
  } else if (off.translation > kLost) {
    ++tally.dropped;
    what = "dropped in transit";
  } else {
    tally.slide.push_back(off.translation);
    tally.turn.push_back(off.angle);
    if (off.translation > kSlid || off.angle > kTurned) {
      ++tally.moved;
      what = "moved in the gripper";
    }
  }
  if (settings.every) print_lift(stone, scene, plan, T_W_T, off, what, results);
}

void report(const std::string& name, const HoldTally& t, Results& results) {
  const auto mm = [&](double share) { return 1e3 * quantile(t.slide, share); };
  const auto deg = [&](double share) { return quantile(t.turn, share) / kDegree; };
  results.row({name, t.tried, t.no_plan, t.stopped, t.not_held, t.dropped, t.moved, mm(0.5), mm(0.9), mm(1.0),
               deg(0.5), deg(0.9), deg(1.0)});
}

/// Seed of the cell of a stone's k-th lift.
int cell_seed(std::uint64_t seed, int k) {
  constexpr std::uint64_t kSeeds = 2147483648;  // that a cell knows
  return static_cast<int>((1000 * seed + static_cast<std::uint64_t>(k)) % kSeeds);
}

/// The lifts of every stone, with grasps that are chosen by one of two strategies.
void measure(const std::vector<Stone>& stones, const Settings& settings, bool press_pads, Results& results) {
  MotionOptions options = settings.motion;
  options.press_pads = press_pads;
  const double start = processor_seconds();
  const std::string chosen = press_pads ? "pressed pads" : "three contacts";
  results.table("grasps chosen by " + chosen, {{"stone"},
                                               {"tried"},
                                               {"no_plan"},
                                               {"stopped"},
                                               {"not_held"},
                                               {"dropped"},
                                               {"moved"},
                                               {"mm_median", 1},
                                               {"mm_p90", 1},
                                               {"mm_max", 1},
                                               {"deg_median", 1},
                                               {"deg_p90", 1},
                                               {"deg_max", 1}});
  HoldTally all;
  for (const Stone& stone : stones) {
    HoldTally tally;
    for (int k = 0; k < settings.picks; ++k) {
      throw_if_interrupted();
      lift(stone, settings, options, cell_seed(settings.common.seed, k), tally, results);
    }
    report(stone.name, tally, results);
    all.add(tally);
  }
  report("all", all, results);
  results.figures("time, " + chosen, {{"cpu_s", processor_seconds() - start, 0}});
}

void measure(const Settings& settings, Results& results) {
  std::vector<Stone> stones = random_stones(settings.common.seed, settings.generated);
  if (stones.empty()) stones = settings.common.read().stones;
  results.settings({{"picks", settings.picks},
                    {"stones", stones.size()},
                    {"generated", settings.generated},
                    {"shift_mm", 1e3 * settings.view.shift},
                    {"turn_deg", settings.view.turn / kDegree},
                    {"fingers_locked", settings.locked},
                    {"moved_beyond_mm", 1e3 * kSlid},
                    {"moved_beyond_deg", kTurned / kDegree},
                    {"seed", settings.common.seed}});
  if (!settings.pads_only) measure(stones, settings, false, results);
  measure(stones, settings, true, results);
}

}  // namespace

void add_hold(CLI::App& app) {
  auto settings = std::make_shared<Settings>();
  CLI::App* sub =
      app.add_subcommand("hold", "Lifts and carries in the simulated cell: what stays in the gripper");
  sub->add_option("--generated", settings->generated,
                  "That many limestones of 7 to 14 cm made from the seed, instead of a catalogue")
      ->check(CLI::Range(1, 1000));
  sub->add_option("--picks", settings->picks, "Lifts of each stone")
      ->check(CLI::Range(1, 999))
      ->capture_default_str();
  settings->view.add_options(*sub);
  sub->add_flag("--locked", settings->locked, "Fingers stay where they stopped (simulation.regrip=false)");
  sub->add_flag("--pads-only", settings->pads_only, "Without the grasps that are chosen by three contacts");
  sub->add_flag("--every", settings->every, "Print every lift with its grasp");
  settings->common.register_draw(*sub);
  sub->footer(
      "Examples:\n  stonestack-bench hold --picks 30 --seed 2\n"
      "  stonestack-bench hold --generated 40 --picks 3 --set simulation.pad_friction_spread=0.15");
  measure_by(*sub, [settings](Results& results) {
    settings->common.settings.apply(
        join({nest("motion", fields(settings->motion)), nest("simulation", fields(settings->simulation))}));
    measure(*settings, results);
  });
}

}  // namespace stonestack::bench
