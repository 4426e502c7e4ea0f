// Prints how far stones move that are pushed over the table in the simulated cell, beside how far they were
// to: stones in resting poses, pushed in one of sixteen directions each, nothing else on the table. Of the
// errors of the named cell those of arm, base and table are left out.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "bench.hpp"
#include "core/constants.hpp"
#include "core/quantile.hpp"
#include "motion/pick_and_place/set_down.hpp"
#include "motion/push.hpp"
#include "motion/regrasp.hpp"
#include "stacking/execute.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/observe.hpp"
#include "stonestack/stone/catalogue.hpp"
#include "view_error.hpp"

namespace stonestack::bench {
namespace {

constexpr int kDirections = 16;
constexpr double kLater = 1.0;                    // s that a stone is looked at after the gripper left
constexpr std::array kLengths{0.03, 0.05, 0.08};  // m

struct PushSettings {
  std::string catalogue = data_path("stones"), cell = "lab";
  int pushes = 60, seed = 1;
  ViewError view{0.0015, 1.0 * kDegree};
  bool every = false;
};

/// Pushes of one length.
struct PushTally {
  int tried = 0, no_plan = 0, something_behind = 0, resisted = 0, stopped = 0;
  std::vector<double> along, aside, turned;  ///< [m], [m], [rad], of those that were pushed all the way
};

void push_once(const std::vector<Stone>& stones, const PushSettings& settings, int number, PushTally& tally,
               double length, Results& results) {
  Random random = Random::stream(static_cast<std::uint64_t>(settings.seed), concat("push ", number));
  const auto any = [&](std::size_t count) {
    return std::min(count - 1, static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(count))));
  };
  const std::vector<Stone> one{stones[any(stones.size())]};
  const Stone& stone = one.front();
  const std::vector<RestPose> rests = rest_poses(stone);
  if (rests.empty()) return;
  const RobotModel robot = read_robot("ur10");
  SimulationOptions options = options_of_cell(settings.cell);
  CellLayout layout;
  layout.linkage = options.linkage;
  options.seed = settings.seed * 1000 + number;
  // The arm's own camera errs with the arm, so these do not count against each other.
  options.arm_kinematics = options.base_translation = options.base_rotation = 0.0;
  options.table_height = options.table_tilt = 0.0;
  options.foreign_objects = 0;
  SimulatedCell simulated(one, {0_stone}, robot, layout, options);
  const Eigen::Quaterniond yaw(
      Eigen::AngleAxisd(random.uniform(-std::numbers::pi, std::numbers::pi), Eigen::Vector3d::UnitZ()));
  simulated.place(0_stone, standing(stone, yaw * rests[any(rests.size())].R_W_O, layout.field_centre, 0.002));
  simulated.wait(2.0);
  const Pose before = simulated.truth().T_W_O[0];
  const double azimuth = 2.0 * std::numbers::pi * static_cast<double>(any(kDirections)) / kDirections;
  const Eigen::Vector2d n_W(std::cos(azimuth), std::sin(azimuth));
  Cell cell = simulated.cell();
  PushTask task;
  task.stone = &stone;
  task.object = 0;
  task.T_W_O = settings.view.estimated(before, random);
  task.p_W_shift = length * n_W;
  task.q_start = cell.arm.state().q;
  Catalogue catalogue;
  catalogue.stones = one;
  const PlanningScene scene = make_planning_scene(layout, robot, catalogue, {{}, {{0_stone, task.T_W_O}}});
  const MotionOptions motion;
  const PickAndPlacePlan plan = plan_push(scene, task, motion);
  ++tally.tried;
  std::string what = plan.reason;
  if (plan.status != PickAndPlacePlan::Status::kPlanned) {
    ++tally.no_plan;
  } else {
    const ExecutionResult done = stacking::execute_push(plan, stone, scene, cell, motion, nullptr);
    if (done.status != ExecutionResult::Status::kStopped) simulated.wait(kLater);
    const Pose after = simulated.truth().T_W_O[0];
    const Eigen::Vector2d moved = (after * stone.mass.p_O_M - before * stone.mass.p_O_M).head<2>();
    const double along = moved.dot(n_W), aside = std::abs(n_W.x() * moved.y() - n_W.y() * moved.x());
    const double turned = difference(before, after).angle;
    what = concat("moved ", std::lround(1e3 * along), " of ", std::lround(1e3 * length), " mm, ",
                  std::lround(1e3 * aside), " mm aside, turned by ", std::lround(turned / kDegree), " deg, ",
                  std::lround(done.contact_force), " N", done.reason.empty() ? "" : ": ", done.reason);
    if (done.status == ExecutionResult::Status::kStopped)
      ++tally.stopped;
    else if (done.status == ExecutionResult::Status::kNotPicked)
      ++tally.something_behind;
    else if (!done.reason.empty())
      ++tally.resisted;
    else {
      tally.along.push_back(along / length);
      tally.aside.push_back(aside);
      tally.turned.push_back(turned);
    }
  }
  if (settings.every) results.note("  %s: %s", stone.name.c_str(), what.c_str());
}

void measure(const PushSettings& settings, Results& results) {
  const std::vector<Stone> stones = read_catalogue(settings.catalogue).stones;
  const double start = processor_seconds();
  results.settings({{"stones", stones.size()},
                    {"cell", settings.cell},
                    {"pushes", settings.pushes},
                    {"shift_mm", 1e3 * settings.view.shift},
                    {"turn_deg", settings.view.turn / kDegree},
                    {"seed", settings.seed}});
  std::array<PushTally, kLengths.size()> tallies;
  for (int k = 0; k < settings.pushes; ++k) {
    throw_if_interrupted();
    const std::size_t length = static_cast<std::size_t>(k) % kLengths.size();
    push_once(stones, settings, k, tallies[length], kLengths[length], results);
  }
  results.table("pushes by how far the stone was to move", {{"wanted_mm", 0},
                                                            {"tried"},
                                                            {"no_plan"},
                                                            {"something_behind"},
                                                            {"resisted"},
                                                            {"stopped"},
                                                            {"pushed"},
                                                            {"share_moved_median"},
                                                            {"share_moved_10_percent"},
                                                            {"aside_mm_median", 1},
                                                            {"turned_deg_median", 0}});
  for (std::size_t i = 0; i < kLengths.size(); ++i) {
    const PushTally& t = tallies[i];
    results.row({1e3 * kLengths[i], t.tried, t.no_plan, t.something_behind, t.resisted, t.stopped,
                 t.along.size(), quantile(t.along, 0.5), quantile(t.along, 0.1), 1e3 * quantile(t.aside, 0.5),
                 quantile(t.turned, 0.5) / kDegree});
  }
  results.figures("time", {{"cpu_s", processor_seconds() - start, 0}});
}

}  // namespace

void add_push(CLI::App& app) {
  auto settings = std::make_shared<PushSettings>();
  CLI::App* sub = app.add_subcommand(
      "push",
      "Stones pushed over the table in the simulated cell without errors of arm and table: how far they "
      "move");
  sub->add_option("--catalogue", settings->catalogue, "Folder of stones (default: those that come along)")
      ->check(CLI::ExistingDirectory);
  sub->add_option("--cell", settings->cell, "Errors of the simulated cell")
      ->check(CLI::IsMember({"ideal", "mild", "lab", "paper", "hard"}))
      ->capture_default_str();
  sub->add_option("--pushes", settings->pushes, "Number of pushes")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  settings->view.add_options(*sub);
  sub->add_flag("--every", settings->every, "Print every push");
  sub->add_option("--seed", settings->seed)->check(CLI::Range(0, 2000000))->capture_default_str();
  sub->footer("Example:\n  stonestack-bench push --pushes 60 --seed 2 --every");
  measure_by(*sub, [settings](Results& results) { measure(*settings, results); });
}

}  // namespace stonestack::bench
