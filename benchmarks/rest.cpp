// Prints how often a stone stays where it is set down in another resting pose: stones are picked up in the
// simulated cell, set down on the table in each resting pose that a grasp leads to in one go, let go and
// looked at, sorted by how far the pose may be tilted before the stone topples.
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "bench.hpp"
#include "core/constants.hpp"
#include "grasp_problems.hpp"
#include "motion/pick_and_place/set_down.hpp"
#include "stacking/execute.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stone/catalogue.hpp"
#include "view_error.hpp"

namespace stonestack::bench {
namespace {

constexpr double kToppled = 15 * kDegree;  // between the stone's up directions: it lies in another pose
constexpr double kLater = 3.0;             // s that it is looked at after the gripper left
constexpr std::array kTilts = {2, 4, 6, 8, 12, 16, 24, 90};  // deg, upper ends of the ranges
constexpr int kStarts = 6;                                   // initial poses, until a grasp leads on

struct RestSettings {
  std::string catalogue = data_path("stones");
  int generated = 0, each = 4, seed = 1;
  ViewError view;
  bool every = false;
};

/// Of one range of tilts.
struct RestTally {
  int poses = 0, no_plan = 0, not_held = 0, set_down = 0, toppled = 0;
};

double between_ups(const Pose& a, const Pose& b) {
  return std::acos(std::clamp(a.linear().row(2).dot(b.linear().row(2)), -1.0, 1.0));
}

/// One stone in a cell of its own, to be set down in one pose.
class Trial {
 public:
  Trial(const Stone& stone, const RestPose& rest, const RestSettings& settings, int number)
      : stones_{stone},
        rest_(rest),
        settings_(settings),
        random_(Random::stream(static_cast<std::uint64_t>(settings.seed), concat(stone.name, " ", number))),
        simulated_(stones_, {0_stone}, robot_, layout_, simulation(number)),
        cell_(simulated_.cell()) {}

  /// False if no grasp leads to the pose from any of the stone's initial poses.
  bool plan() {
    for (int start = 0; start < kStarts; ++start) {
      if (start > 0) {
        const Pose lying = standing_at(stones_[0], rest(stones_[0], random_),
                                       simulated_.truth().T_W_O[0].translation().head<2>(), 0.002);
        simulated_.place(0_stone, lying);
        simulated_.wait(2.0);
      }
      PickAndPlaceTask task;
      task.stone = stones_.data();
      task.object = 0;
      task.T_W_O_pick = settings_.view.estimated(simulated_.truth().T_W_O[0], random_);
      const Eigen::Quaterniond yaw(
          Eigen::AngleAxisd(random_.uniform(-std::numbers::pi, std::numbers::pi), Eigen::Vector3d::UnitZ()));
      T_W_O_down_ = standing(stones_[0], yaw * rest_.R_W_O, layout_.site, 0.0);
      task.T_W_O_place = T_W_O_down_;
      task.q_start = cell_.arm.state().q;
      scene_.robot = robot_;
      scene_.T_W_R = layout_.T_W_R;
      scene_.T_F_T = layout_.T_F_T;
      scene_.objects = {{stones_[0].name, stones_[0].pieces, task.T_W_O_pick}};
      plan_ = plan_pick_and_place(scene_, task, options_);
      if (plan_.status == PickAndPlacePlan::Status::kPlanned) return true;
    }
    return false;
  }

  /// False if the stone was lost in transit.
  bool execute() {
    if (stacking::execute(plan_, stones_[0], scene_, cell_, options_, nullptr).status !=
        ExecutionResult::Status::kReleased)
      return false;
    simulated_.wait(kLater);
    const Pose& T_W_O = simulated_.truth().T_W_O[0];
    turned_ = between_ups(T_W_O, T_W_O_down_);
    moved_ = (T_W_O.translation() - T_W_O_down_.translation()).norm();
    return true;
  }
  [[nodiscard]] double turned() const { return turned_; }
  [[nodiscard]] double moved() const { return moved_; }

 private:
  [[nodiscard]] SimulationOptions simulation(int number) const {
    SimulationOptions options;
    options.seed = settings_.seed * 1000 + number;
    return options;
  }

  const RobotModel robot_ = read_robot("ur10");
  const CellLayout layout_;
  const MotionOptions options_;
  std::vector<Stone> stones_;
  RestPose rest_;
  const RestSettings& settings_;
  Random random_;
  SimulatedCell simulated_;
  Cell cell_;
  PlanningScene scene_;
  Pose T_W_O_down_ = Pose::Identity();
  PickAndPlacePlan plan_;
  double turned_ = 0.0, moved_ = 0.0;
};

void set_down(const Stone& stone, const RestPose& rest, const RestSettings& settings, int number,
              RestTally& tally, Results& results) {
  Trial trial(stone, rest, settings, number);
  std::string what = "no grasp leads there";
  if (!trial.plan()) {
    ++tally.no_plan;
  } else if (!trial.execute()) {
    ++tally.not_held;
    what = "not held";
  } else {
    ++tally.set_down;
    const bool toppled = trial.turned() > kToppled;
    tally.toppled += toppled ? 1 : 0;
    what = concat(toppled ? "toppled" : "stays", ", turned by ", std::lround(trial.turned() / kDegree),
                  " deg, moved by ", std::lround(1e3 * trial.moved()), " mm");
  }
  if (settings.every)
    results.note("  %s: margin %.1f mm, tilt %.1f deg: %s", stone.name.c_str(), 1e3 * rest.margin,
                 rest.tilt / kDegree, what.c_str());
}

void measure(const RestSettings& settings, Results& results) {
  std::vector<Stone> stones;
  for (int k = 0; k < settings.generated; ++k)
    stones.push_back(random_stone(static_cast<std::uint64_t>(100 * settings.seed + k),
                                  concat("limestone ", k), 0.09, 0.18));
  if (stones.empty()) stones = read_catalogue(settings.catalogue).stones;
  const double start = processor_seconds();
  RegraspOptions shaky;
  shaky.rest_margin = shaky.min_margin;
  shaky.rest_tilt = 0.0;
  results.settings({{"stones", stones.size()},
                    {"margin_mm", 1e3 * shaky.rest_margin},
                    {"each", settings.each},
                    {"shift_mm", 1e3 * settings.view.shift},
                    {"turn_deg", settings.view.turn / kDegree},
                    {"seed", settings.seed}});
  std::array<RestTally, kTilts.size()> tallies;
  for (const Stone& stone : stones)
    for (const RestPose& rest : rest_poses(stone, shaky)) {
      std::size_t range = 0;
      while (range + 1 < kTilts.size() && rest.tilt > kTilts[range] * kDegree) ++range;
      ++tallies[range].poses;
      for (int k = 0; k < settings.each; ++k) {
        throw_if_interrupted();
        set_down(stone, rest, settings, k, tallies[range], results);
      }
    }
  results.table("resting poses by the tilt beyond which they topple",
                {{"from_deg"}, {"to_deg"}, {"poses"}, {"no_plan"}, {"not_held"}, {"set_down"}, {"toppled"}});
  for (std::size_t i = 0; i < kTilts.size(); ++i)
    results.row({i == 0 ? 0 : kTilts[i - 1], kTilts[i], tallies[i].poses, tallies[i].no_plan,
                 tallies[i].not_held, tallies[i].set_down, tallies[i].toppled});
  results.figures("time", {{"cpu_s", processor_seconds() - start, 0}});
}

}  // namespace

void add_rest(CLI::App& app) {
  auto settings = std::make_shared<RestSettings>();
  CLI::App* sub = app.add_subcommand(
      "rest", "Stones set down in other resting poses in the simulated cell: which topple");
  sub->add_option("--catalogue", settings->catalogue, "Folder of stones (default: those that come along)")
      ->check(CLI::ExistingDirectory);
  sub->add_option("--generated", settings->generated, "That many limestones of 9 to 18 cm instead")
      ->check(CLI::Range(1, 1000));
  sub->add_option("--each", settings->each, "Times that each pose is tried")
      ->check(CLI::Range(1, 999))
      ->capture_default_str();
  settings->view.add_options(*sub);
  sub->add_flag("--every", settings->every, "Print every trial");
  sub->add_option("--seed", settings->seed)->check(CLI::Range(0, 2000000))->capture_default_str();
  sub->footer("Example:\n  stonestack-bench rest --each 10 --seed 2");
  measure_by(*sub, [settings](Results& results) { measure(*settings, results); });
}

}  // namespace stonestack::bench
