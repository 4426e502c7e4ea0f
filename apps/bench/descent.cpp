// Prints how guarded descents end in the simulated cell: stones of many sizes are picked up once each and
// then set on the table or on another stone again and again, at random places, speeds and delays of the
// force.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>

#include "bench.hpp"
#include "grasp_problems.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/quantile.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/kinematics/forward.hpp"
#include "stonestack/motion/cartesian.hpp"
#include "stonestack/motion/timing.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/execute.hpp"

namespace stonestack::apps {
namespace {

using Status = MotionResult::Status;

constexpr double kHighest = 0.12;   // m, between stone and support while the hand moves aside
constexpr double kGap = 0.0005;     // m: contact that is reported further away is a false trigger
constexpr double kSlipped = 0.015;  // m, in the hand: then another stone is taken
constexpr double kLeastSpeed = 0.003, kMostSpeed = 0.007;  // m/s, the default is 0.005
constexpr double kMostDelay = 0.020;                       // s
constexpr double kForceMark = 30.0;                        // N

struct Tally {
  int descents = 0, missed = 0, early = 0, stopped = 0, hard = 0, on_stone = 0;
  std::vector<double> peaks, depths;
};

double lowest(const Stone& stone, const Pose& T_W_O) {
  double z = 1e9;
  for (const Eigen::Vector3d& p : stone.scan.vertices) z = std::min(z, (T_W_O * p).z());
  return z;
}
double highest(const Stone& stone, const Pose& T_W_O) {
  double z = -1e9;
  for (const Eigen::Vector3d& p : stone.scan.vertices) z = std::max(z, (T_W_O * p).z());
  return z;
}

/// One cell with the stone that is carried (0) and the one it is set on (1).
class Trial {
 public:
  Trial(const std::vector<Stone>& stones, const SimulationOptions& simulation, Random random)
      : stones_(stones),
        random_(random),
        simulated_(stones, {0, 1}, robot_, layout_, simulation),
        cell_(simulated_.cell()) {}

  /// False if no plan or no grasp comes about.
  bool pick() {
    const auto truth = simulated_.truth();  // the setting of the experiment; nothing of it is used below
    PlanningScene scene;
    scene.robot = robot_;
    scene.T_F_T = layout_.T_F_T;
    for (std::size_t i = 0; i < 2; ++i)
      scene.objects.push_back({stones_[i].name, stones_[i].pieces, truth.T_W_O[i]});
    PickAndPlaceTask task;
    task.stone = &stones_[0];
    task.object = 0;
    task.T_W_O_pick = truth.T_W_O[0];
    task.T_W_O_place = task.T_W_O_pick;
    task.T_W_O_place.translation().head<2>() = layout_.site;
    task.q_start = cell_.arm.state().q;
    PickAndPlacePlan plan = plan_pick_and_place(scene, task);
    if (plan.status != PickAndPlacePlan::Status::kPlanned) return false;
    const auto lift = std::find_if(plan.steps.begin(), plan.steps.end(),
                                   [](const PlanStep& step) { return step.kind == PlanStep::Kind::kLift; });
    plan.steps.erase(lift + 1, plan.steps.end());
    if (execute(plan, stones_[0], scene, cell_, options_, nullptr).status !=
        ExecutionResult::Status::kReleased)
      return false;
    T_T_O_ = T_W_T().inverse() * simulated_.truth().T_W_O[0];
    return true;
  }

  /// One descent; false when the stone has to be taken anew.
  bool descend(bool on_stone, Tally& tally) {
    const Eigen::Vector2d at =
        layout_.site + Eigen::Vector2d(random_.uniform(-0.15, 0.15), random_.uniform(-0.10, 0.10));
    double support = 0.0;
    if (!go_up()) return false;
    if (on_stone) {  // it lies as it fell in the field, only elsewhere
      Pose T_W_O = simulated_.truth().T_W_O[1];
      T_W_O.translation().head<2>() = at + Eigen::Vector2d(random_.uniform(-0.02, 0.02), 0.0);
      simulated_.place(1, T_W_O);
      simulated_.wait(0.5);
      support = highest(stones_[1], simulated_.truth().T_W_O[1]);
    }
    if (!go_above(at, support + kHighest)) return true;
    const double gap = random_.uniform(0.005, 0.030);
    if (!go_down(kHighest - gap)) return true;
    ++tally.descents;
    tally.on_stone += on_stone ? 1 : 0;
    measure(gap + support, tally);
    return go_up() && still_held();
  }

 private:
  [[nodiscard]] Pose T_W_T() { return layout_.T_W_R * forward(robot_, cell_.arm.state().q) * layout_.T_F_T; }

  [[nodiscard]] std::optional<JointTrajectory> straight(const Pose& T_W_T_goal, double speed) {
    const auto path =
        straight_path(robot_, layout_.T_F_T, cell_.arm.state().q, layout_.T_W_R.inverse() * T_W_T_goal);
    if (!path) return std::nullopt;
    TimingLimits limits = timing_limits(robot_, options_);
    limits.tool_speed = speed;
    limits.blend = 0.0003;
    return time_path(*path, limits, robot_, layout_.T_F_T);
  }
  bool go(const Pose& T_W_T_goal, double speed) {
    const auto trajectory = straight(T_W_T_goal, speed);
    return trajectory && cell_.arm.follow(*trajectory).status == Status::kDone;
  }
  bool go_up() {
    Pose T = T_W_T();
    const double z = lowest(stones_[0], simulated_.truth().T_W_O[0]);
    T.translation().z() += std::max(0.0, 0.30 - z);
    return go(T, 0.15);
  }
  bool go_above(const Eigen::Vector2d& at, double stone_z) {
    const Pose T_W_O = simulated_.truth().T_W_O[0];
    Pose T = T_W_T();
    T.translation().head<2>() += at - T_W_O.translation().head<2>();
    T.translation().z() += stone_z - lowest(stones_[0], T_W_O);
    return go(T, 0.25);
  }
  bool go_down(double by) {
    Pose T = T_W_T();
    T.translation().z() -= by;
    return go(T, options_.approach_speed);
  }

  void measure(double far, Tally& tally) {
    Pose T = T_W_T();
    T.translation().z() -= std::min(far, 0.060) + options_.descent_past;
    GuardedMotion motion;
    const auto way = straight(T, random_.uniform(kLeastSpeed, kMostSpeed));
    if (!way) return void(--tally.descents);
    motion.trajectory = *way;
    motion.threshold = contact_threshold(stones_[0].mass.mass, options_);
    cell_.force_torque.zero();
    const double rest = level_force();
    const MotionResult result = cell_.arm.follow_guarded(motion);
    double peak = result.force;
    for (int i = 0; i < 3; ++i) peak = std::max(peak, level_force() - rest);
    const bool touches = touching();
    if (result.status == Status::kNoContact) ++(touches ? tally.missed : tally.stopped);
    if (result.status == Status::kContact && !touches) ++tally.early;
    if (result.status != Status::kContact && result.status != Status::kNoContact) ++tally.stopped;
    if (peak > kForceMark) ++tally.hard;
    tally.peaks.push_back(peak);
  }
  /// Upward force at the wrist, N.
  double level_force() {
    const Pose T_W_F = layout_.T_W_R * forward(robot_, cell_.arm.state().q);
    return (T_W_F.linear() * cell_.force_torque.read().force).z();
  }
  /// True if the carried stone is on something, or nearer than kGap above the table.
  bool touching() {
    const auto truth = simulated_.truth();
    if (lowest(stones_[0], truth.T_W_O[0]) < kGap) return true;
    return std::any_of(truth.contacts.begin(), truth.contacts.end(),
                       [](const Contact& c) { return c.above == 0 || c.below == 0; });
  }
  bool still_held() {
    return difference(T_T_O_, T_W_T().inverse() * simulated_.truth().T_W_O[0]).translation < kSlipped;
  }

  const std::vector<Stone>& stones_;
  Random random_;
  RobotModel robot_ = read_robot("ur10");
  CellLayout layout_;
  MotionOptions options_;
  SimulatedCell simulated_;
  Cell cell_;
  Pose T_T_O_ = Pose::Identity();
};

void measure(int descents, int each, std::uint64_t seed) {
  const double start = processor_seconds();
  Tally tally;
  int picked = 0, not_picked = 0;
  std::vector<double> masses;
  for (std::uint64_t n = 0; tally.descents < descents; ++n) {
    throw_if_interrupted();
    require(not_picked < 10 + 10 * picked, "no stone can be picked up: ", not_picked, " failed");
    Random random = Random::stream(seed, n);
    const std::vector<Stone> stones{
        bench::random_stone(static_cast<std::uint64_t>(random.index(1000000000)), "carried", 0.07, 0.14),
        bench::random_stone(static_cast<std::uint64_t>(random.index(1000000000)), "support", 0.12, 0.16)};
    SimulationOptions simulation;
    simulation.seed = static_cast<int>(seed % 10000 * 100000 + n);
    simulation.force_delay = random.uniform(0.0, kMostDelay);
    Trial trial(stones, simulation, random);
    if (!trial.pick()) {
      ++not_picked;
      continue;
    }
    ++picked;
    masses.push_back(stones[0].mass.mass);
    for (int k = 0; k < each && tally.descents < descents; ++k)
      if (!trial.descend(random.uniform() < 0.5, tally)) break;
  }
  std::printf("%d descents, %d of them on a stone, with %d stones of %.2f to %.2f kg, seed %d; CPU s %.0f\n",
              tally.descents, tally.on_stone, picked, quantile(masses, 0.0), quantile(masses, 1.0),
              static_cast<int>(seed), processor_seconds() - start);
  std::printf(
      "missed contacts %d, false triggers %d, other ends %d; peak force N: median %.1f, 95 %% %.1f, "
      "largest %.1f; above %.0f N: %d\n",
      tally.missed, tally.early, tally.stopped, quantile(tally.peaks, 0.5), quantile(tally.peaks, 0.95),
      quantile(tally.peaks, 1.0), kForceMark, tally.hard);
}

}  // namespace

void add_bench_descent(CLI::App& bench) {
  struct Command {
    int descents = 100;
    int each = 20;
    int seed = 1;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub =
      bench.add_subcommand("descent", "Guarded descents in the simulated cell: contacts and forces");
  sub->add_option("--descents", command->descents)->check(CLI::Range(1, 1000000))->capture_default_str();
  sub->add_option("--each", command->each, "Descents with one stone")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub->add_option("--seed", command->seed)->check(CLI::Range(0, 2147483647))->capture_default_str();
  sub->footer("Example:\n  stonestack bench descent --descents 1000");
  sub->callback(
      [command] { measure(command->descents, command->each, static_cast<std::uint64_t>(command->seed)); });
}

}  // namespace stonestack::apps
