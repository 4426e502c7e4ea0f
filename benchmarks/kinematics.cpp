// Prints, for every robot as drawn and as calibrated: inverse solutions recovered, worst residual, processor
// time a call.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "bench.hpp"
#include "kinematics/dh.hpp"
#include "kinematics/inverse.hpp"
#include "kinematics/jacobian.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::bench {
namespace {

constexpr int kCalibrations = 20;  // drawn for each robot

/// How far a calibration moves and turns each joint's frame, one sigma an axis.
struct CalibrationDraw {
  double length = 0.001;  // m
  double angle = 0.002;   // rad
};

struct Problem {
  Joints q;
  Pose T_R_F;
};

std::vector<Problem> random_problems(const RobotModel& robot, std::size_t count, std::uint64_t seed) {
  Random random = Random::stream(seed, robot.name);
  std::vector<Problem> problems(count);
  for (auto& [q, T_R_F] : problems) {
    for (Eigen::Index i = 0; i < 6; ++i) q[i] = random.uniform(robot.lower[i], robot.upper[i]);
    T_R_F = forward(robot, q);
  }
  return problems;
}

/// Shoulder angle (DH) that brings the wrist's centre nearest to the base's axis.
double over_base(const RobotModel& robot, const Joints& t) {
  const double c = robot.a2 + robot.a3 * std::cos(t[2]) + robot.d5 * std::sin(t[2] + t[3]);
  const double s = -robot.a3 * std::sin(t[2]) + robot.d5 * std::cos(t[2] + t[3]);
  return std::atan2(-c, s);
}

/// Every combination of wrist in line, elbow stretched or folded and wrist over the base, each exactly or
/// beside it by 1e-12 to 1e-3 rad of its own. What is singular is asked for in DH angles.
std::vector<Problem> singular_problems(const RobotModel& robot, std::size_t count, std::uint64_t seed) {
  constexpr std::array kBeside{0.0, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-4, 1e-3};
  constexpr double kPi = 3.14159265358979323846;
  Random random = Random::stream(seed, robot.name + " singular");
  std::vector<Problem> problems(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t kind = 1 + i % 7;
    const auto beside = [&] {
      return (random.uniform() < 0.5 ? -1 : 1) * kBeside[random.index(kBeside.size())];
    };
    Joints t;
    for (auto& angle : t) angle = random.uniform(-kPi, kPi);
    if ((kind & 1) != 0) t[4] = kPi * static_cast<double>(random.index(2)) + beside();
    if ((kind & 2) != 0) t[2] = kPi * static_cast<double>(random.index(2)) + beside();
    if ((kind & 4) != 0) t[1] = over_base(robot, t) + kPi * static_cast<double>(random.index(2)) + beside();
    problems[i].q = t - robot.dh_offset;
    problems[i].T_R_F = forward(robot, problems[i].q);
  }
  return problems;
}

/// Every singular pose must be met, by solutions that are all good; the seed knows nothing of the answer.
void measure_singular(const std::string& name, std::size_t count, std::uint64_t seed, Results& results) {
  const RobotModel robot = read_robot(name);
  std::size_t met = 0, bad = 0;
  double worst = 0.0;
  for (const auto& [q, T_R_F] : singular_problems(robot, count, seed)) {
    const IkBranches found = inverse_branches(robot, T_R_F, Joints::Zero());
    for (int i = 0; i < found.count; ++i) {
      const Joints& s = found.solutions[static_cast<std::size_t>(i)].q;
      const double off = (forward(robot, s).matrix() - T_R_F.matrix()).cwiseAbs().maxCoeff();
      if (!(off <= 1e-9)) ++bad;
      if (std::isfinite(off)) worst = std::max(worst, off);
    }
    met += found.count > 0 ? 1 : 0;
    throw_if_interrupted();
  }
  results.row({name, count, met, worst, bad});
}

void measure(const std::string& name, std::size_t count, std::uint64_t seed, Results& results) {
  const RobotModel robot = read_robot(name);
  const auto problems = random_problems(robot, count, seed);
  std::size_t recovered = 0, solutions = 0;
  double worst = 0.0;
  for (const auto& [q, T_R_F] : problems) {
    const IkBranches found = inverse_branches(robot, T_R_F, q);
    bool same = false;
    for (int i = 0; i < found.count; ++i) {
      const Joints& s = found.solutions[static_cast<std::size_t>(i)].q;
      const double off = (forward(robot, s).matrix() - T_R_F.matrix()).cwiseAbs().maxCoeff();
      worst = std::max(worst, off == off ? off : 1e9);
      same = same || (s - q).cwiseAbs().maxCoeff() < 1e-5;
    }
    recovered += same ? 1 : 0;
    solutions += static_cast<std::size_t>(found.count);
    throw_if_interrupted();
  }
  const double branches_start = processor_seconds();
  volatile int kept = 0;
  for (const auto& [q, T_R_F] : problems) kept = kept + inverse_branches(robot, T_R_F, q).count;
  const double branches_seconds = processor_seconds() - branches_start;
  const double all_start = processor_seconds();
  std::size_t all = 0;
  for (std::size_t i = 0; i < count; i += 10) all += inverse(robot, problems[i].T_R_F, problems[i].q).size();
  const double all_seconds = processor_seconds() - all_start;
  const double forward_start = processor_seconds();
  volatile double sum = 0.0;  // the calls must not be optimised away
  for (const auto& [q, T_R_F] : problems) sum = sum + forward(robot, q).translation().x();
  const double forward_seconds = processor_seconds() - forward_start;
  const auto n = static_cast<double>(count);
  results.row({name, count, recovered, static_cast<double>(solutions) / n, worst, 1e6 * branches_seconds / n,
               1e7 * all_seconds / n, 10.0 * static_cast<double>(all) / n, 1e6 * forward_seconds / n});
}

/// The robot with every joint's frame a little off, as a factory calibration finds it.
RobotModel calibrated(RobotModel robot, const CalibrationDraw& draw, Random& random) {
  const RobotModel drawn = robot;
  for (;;) {
    const auto three = [&](double sigma) {
      return Eigen::Vector3d(random.normal(0, sigma), random.normal(0, sigma), random.normal(0, sigma));
    };
    for (std::size_t i = 0; i < 6; ++i) {
      const Eigen::Vector3d turn = three(draw.angle);
      robot.T_parent_joint[i] = drawn.T_parent_joint[i] * Eigen::Translation3d(three(draw.length)) *
                                Eigen::AngleAxisd(turn.norm(), turn.normalized());
    }
    if (derive_dh(robot).empty()) return robot;  // a draw beyond what read_robot takes is drawn again
  }
}

/// Largest difference of two joint vectors, whole turns not counted.
double apart(const Joints& a, const Joints& b) {
  double max = 0.0;
  for (Eigen::Index i = 0; i < 6; ++i)
    max = std::max(max, std::abs(std::remainder(a[i] - b[i], 2.0 * 3.14159265358979323846)));
  return max;
}

/// Random poses of calibrated robots. The seed knows nothing of the answer.
void measure_calibrated(const std::string& name, const CalibrationDraw& draw, std::size_t count,
                        std::uint64_t seed, Results& results) {
  Random random = Random::stream(seed, name + " calibrations");
  std::size_t recovered = 0, solutions = 0, poses = 0;
  double worst = 0.0, seconds = 0.0, missed = 0.0;
  for (std::uint64_t k = 0; k < kCalibrations; ++k) {
    const RobotModel robot = calibrated(read_robot(name), draw, random);
    const auto problems = random_problems(robot, std::max<std::size_t>(1, count / kCalibrations), seed + k);
    std::vector<IkBranches> found(problems.size());
    const double start = processor_seconds();
    for (std::size_t i = 0; i < problems.size(); ++i)
      found[i] = inverse_branches(robot, problems[i].T_R_F, Joints::Zero());
    seconds += processor_seconds() - start;
    poses += problems.size();
    for (std::size_t i = 0; i < problems.size(); ++i) {
      bool same = false;
      for (int b = 0; b < found[i].count; ++b) {
        const Joints& s = found[i].solutions[static_cast<std::size_t>(b)].q;
        const double off = (forward(robot, s).matrix() - problems[i].T_R_F.matrix()).cwiseAbs().maxCoeff();
        worst = std::max(worst, off == off ? off : 1e9);
        same = same || apart(s, problems[i].q) < 1e-5;
      }
      recovered += same ? 1 : 0;
      if (!same) missed = std::max(missed, manipulability(robot, problems[i].q));
      solutions += static_cast<std::size_t>(found[i].count);
    }
    throw_if_interrupted();
  }
  const TableValue max_missed = recovered < poses ? TableValue(missed) : TableValue();
  results.row({name, poses, recovered, static_cast<double>(solutions) / static_cast<double>(poses), worst,
               1e6 * seconds / static_cast<double>(poses), max_missed});
}

}  // namespace

void add_kinematics(CLI::App& app) {
  struct Command {
    int poses = 100000;
    int seed = 1;
    CalibrationDraw draw;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand("kinematics",
                                     "Inverse kinematics: recovered poses, residual, time a call; a tenth "
                                     "as many singular poses, and as many "
                                     "of calibrated robots");
  sub->add_option("--poses", command->poses, "Random joint positions a robot")
      ->check(CLI::Range(1, 100000000))
      ->capture_default_str();
  sub->add_option("--seed", command->seed)->check(CLI::Range(0, 2147483647))->capture_default_str();
  sub->add_option("--calibration-length", command->draw.length,
                  "m, by which calibrated robots' joint frames are moved (one sigma an axis)")
      ->check(CLI::Range(0.0, 0.005))
      ->capture_default_str();
  sub->add_option("--calibration-angle", command->draw.angle, "rad, by which they are turned")
      ->check(CLI::Range(1e-6, 0.01))
      ->capture_default_str();
  sub->footer("Example:\n  stonestack-bench kinematics --poses 1000000");
  measure_by(*sub, [command](Results& results) {
    const auto seed = static_cast<std::uint64_t>(command->seed);
    const auto poses = static_cast<std::size_t>(command->poses);
    const std::size_t tenth = std::max<std::size_t>(1, poses / 10);
    results.settings({{"poses", poses},
                      {"calibrations", kCalibrations},
                      {"calibration_length_m", command->draw.length},
                      {"calibration_angle_rad", command->draw.angle},
                      {"seed", command->seed}});
    results.table("random poses", {{"robot"},
                                   {"poses"},
                                   {"recovered"},
                                   {"branches"},
                                   {"residual_max", -1},
                                   {"us_branches"},
                                   {"us_with_every_turn", 1},
                                   {"solutions_with_every_turn", 0},
                                   {"us_forward"}});
    for (const auto& name : robot_names()) measure(name, poses, seed, results);
    results.table("singular poses",
                  {{"robot"}, {"poses"}, {"met"}, {"residual_max", -1}, {"beyond_1e-9_or_nan"}});
    for (const auto& name : robot_names()) measure_singular(name, tenth, seed, results);
    results.table("poses of calibrated robots", {{"robot"},
                                                 {"poses"},
                                                 {"recovered"},
                                                 {"branches"},
                                                 {"residual_max", -1},
                                                 {"us_branches", 1},
                                                 {"manipulability_of_missed_max", -1}});
    for (const auto& name : robot_names()) measure_calibrated(name, command->draw, tenth, seed, results);
  });
}

}  // namespace stonestack::bench
