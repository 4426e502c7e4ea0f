// How often the tool can be moved straight (cartesian), and what timing a path costs, whether it keeps its
// limits and how near it comes to the least time (timing).
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "bench.hpp"
#include "core/constants.hpp"
#include "core/quantile.hpp"
#include "kinematics/inverse.hpp"
#include "motion/cartesian.hpp"
#include "motion/constants.hpp"
#include "motion/path/min_time.hpp"
#include "motion/timing.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/hardware/cell.hpp"

namespace stonestack::bench {
namespace {

constexpr double kTilt = 25.0 * kPi / 180.0;  // off the vertical, most: "near-vertical"
constexpr double kResample = 0.001;           // s
constexpr double kJerk = 50.0;                // rad/s^3

/// A tool pose on the side of the robot where stones lie, as far out as `reach` (m), pointing down within
/// kTilt.
Pose near_vertical(Random& random, double reach) {
  const double r = reach * random.uniform(0.35, 0.75), turn = random.uniform(-kPi, kPi);
  const Eigen::Vector3d p(r * std::cos(turn), r * std::sin(turn), random.uniform(0.02, 0.35));
  const double side = random.uniform(-kPi, kPi);
  const Eigen::AngleAxisd tilt(random.uniform(0.0, kTilt),
                               Eigen::Vector3d(std::cos(side), std::sin(side), 0));
  const Eigen::AngleAxisd yaw(random.uniform(-kPi, kPi), Eigen::Vector3d::UnitZ());
  return make_pose(p, tilt * yaw * Eigen::Quaterniond(0, 1, 0, 0));
}

/// The straight motions of one placing: back along the tool (approach and retreat are the same line), up, and
/// down through the guarded descent.
std::array<Pose, 3> ends_of(const Pose& T, const MotionOptions& options) {
  return {T * Pose(Eigen::Translation3d(0, 0, -options.approach)),
          Pose(Eigen::Translation3d(0, 0, kLiftHeight)) * T,
          Pose(Eigen::Translation3d(0, 0, -options.descent_past)) * T};
}

void measure_cartesian(const std::string& name, int poses, std::uint64_t seed, Results& results) {
  const RobotModel robot = read_robot(name);
  const Pose T_F_T = CellLayout{}.T_F_T;
  const MotionOptions motion;
  const double reach = std::abs(robot.a2) + std::abs(robot.a3);
  const auto reached = [&](const Pose& T) { return inverse(robot, T * T_F_T.inverse(), Joints::Zero()); };
  Random random = Random::stream(seed, "near-vertical poses");
  std::array<int, 3> reachable{}, tracked{};
  std::array<std::vector<double>, 3> milliseconds;
  for (int n = 0; n < poses; ++n) {
    throw_if_interrupted();
    const Pose T = near_vertical(random, reach);
    const auto solutions = reached(T);
    const auto ends = ends_of(T, motion);
    for (std::size_t e = 0; e < ends.size(); ++e) {
      if (solutions.empty() || reached(ends[e]).empty()) continue;
      ++reachable[e];
      const double start = processor_seconds();
      const bool found = std::any_of(solutions.begin(), solutions.end(), [&](const IkSolution& s) {
        return straight_path(robot, T_F_T, s.q, ends[e]).has_value();
      });
      milliseconds[e].push_back(1e3 * (processor_seconds() - start));
      tracked[e] += found ? 1 : 0;
    }
  }
  constexpr std::array kMotions{"approach and retreat", "lift and lowering", "descent"};
  for (std::size_t e = 0; e < kMotions.size(); ++e)
    results.row({kMotions[e], name, reachable[e], tracked[e],
                 reachable[e] > 0 ? TableValue(100.0 * tracked[e] / reachable[e]) : TableValue(),
                 quantile(milliseconds[e], 0.5), quantile(milliseconds[e], 0.95)});
}

/// Largest velocity, acceleration and jerk over their limits, by differences of what is sampled at 1 kHz.
struct Excess {
  double velocity = 0.0, acceleration = 0.0, jerk = 0.0;
  void record(const JointTrajectory& t, const TimingLimits& limits, double max_jerk) {
    JointState last = sample(t, 0.0);
    Joints last_acceleration = Joints::Zero();
    for (long k = 1; static_cast<double>(k) * kResample <= t.duration(); ++k) {
      const JointState now = sample(t, static_cast<double>(k) * kResample);
      const Joints a = (now.qd - last.qd) / kResample;
      velocity = std::max(velocity, now.qd.cwiseAbs().cwiseQuotient(limits.velocity).maxCoeff());
      acceleration = std::max(acceleration, a.cwiseAbs().cwiseQuotient(limits.acceleration).maxCoeff());
      if (max_jerk > 0 && k > 1)
        jerk = std::max(jerk, (a - last_acceleration).cwiseAbs().maxCoeff() / kResample / max_jerk);
      last = now;
      last_acceleration = a;
    }
  }
};

void measure_timing(int paths, std::uint64_t seed, Results& results) {
  const RobotModel robot = read_robot("ur10");
  Random random = Random::stream(seed, "paths of ten way points");
  std::vector<double> milliseconds, ratios, slower;
  Excess plain, smooth;
  for (int n = 0; n < paths; ++n) {
    throw_if_interrupted();
    JointPath path(10);
    for (Joints& q : path)
      for (double& angle : q) angle = random.uniform(-2.0, 2.0);
    TimingLimits limits = timing_limits(robot, {});
    limits.blend = std::array{0.005, 0.05, 0.2}[static_cast<std::size_t>(n % 3)];
    const double start = processor_seconds();
    const JointTrajectory trajectory = time_path(path, limits);
    milliseconds.push_back(1e3 * (processor_seconds() - start));
    ratios.push_back(trajectory.duration() / min_time(path, limits));
    plain.record(trajectory, limits, 0.0);
    limits.jerk = kJerk;
    const JointTrajectory limited = time_path(path, limits);
    slower.push_back(limited.duration() / trajectory.duration());
    smooth.record(limited, limits, kJerk);
  }
  results.figures("timing", {{"ms_median", quantile(milliseconds, 0.5), 3},
                             {"ms_p95", quantile(milliseconds, 0.95), 3},
                             {"ms_max", quantile(milliseconds, 1.0), 3},
                             {"duration_over_min_median", quantile(ratios, 0.5), 4},
                             {"duration_over_min_max", quantile(ratios, 1.0), 4}});
  results.table(
      "largest at 1 kHz over its limit",
      {{"jerk"}, {"velocity", 6}, {"acceleration", 6}, {"jerk_over_limit", 6}, {"times_as_long_median", 3}});
  results.row({"unlimited", plain.velocity, plain.acceleration, TableValue(), 1.0});
  results.row({"limited", smooth.velocity, smooth.acceleration, smooth.jerk, quantile(slower, 0.5)});
}

}  // namespace

void add_cartesian(CLI::App& app) {
  struct Command {
    int poses = 10000;
    int seed = 1;
    std::string robot;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand(
      "cartesian", "How many reachable poses within 25 deg of the vertical have straight motions");
  sub->add_option("--poses", command->poses)->check(CLI::Range(1, 100000000))->capture_default_str();
  sub->add_option("--seed", command->seed)->check(CLI::Range(0, 2147483647))->capture_default_str();
  sub->add_option("--robot", command->robot, "Only this one (default: all that we know)");
  sub->footer("Example:\n  stonestack-bench cartesian --poses 100000 --robot ur10");
  measure_by(*sub, [command](Results& results) {
    results.settings({{"poses", command->poses}, {"seed", command->seed}});
    results.table(
        "straight motions with both ends in reach",
        {{"motion"}, {"robot"}, {"reachable"}, {"straight"}, {"percent"}, {"ms_median"}, {"ms_p95"}});
    const auto names = command->robot.empty() ? robot_names() : std::vector<std::string>{command->robot};
    for (const auto& name : names)
      measure_cartesian(name, command->poses, static_cast<std::uint64_t>(command->seed), results);
  });
}

void add_timing(CLI::App& app) {
  struct Command {
    int paths = 300;
    int seed = 1;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand("timing", "What timing costs, against limits and the least time");
  sub->add_option("--paths", command->paths)->check(CLI::Range(1, 10000000))->capture_default_str();
  sub->add_option("--seed", command->seed)->check(CLI::Range(0, 2147483647))->capture_default_str();
  sub->footer("Example:\n  stonestack-bench timing --paths 1000");
  measure_by(*sub, [command](Results& results) {
    results.settings({{"paths", command->paths},
                      {"waypoints", 10},
                      {"jerk_limit_rad_s3", kJerk},
                      {"seed", command->seed}});
    measure_timing(command->paths, static_cast<std::uint64_t>(command->seed), results);
  });
}

}  // namespace stonestack::bench
