#include "kinematics/inverse.hpp"

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "kinematics/calibrated_inverse.hpp"
#include "kinematics/closed_form.hpp"
#include "kinematics/polish.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::kinematics {
namespace {

constexpr double kRounding = 1e-5;  // m: what rounding may make of a reachable pose where singularities meet
constexpr double kLimitSlack = 2e-10;  // rad: an angle this far outside its limit is set onto it

constexpr double kFarthest = 1e6;  // rad: of a seed; further away rounding eats the angle

bool is_seed(const Joints& seed) {
  return (seed.array().abs() <= kFarthest).all();  // false for NaN
}

/// The values of angle + 2 pi k within the limits; at most four, for limits within a turn either way.
struct Equivalents {
  std::array<double, 4> values{};
  int count = 0;
};

Equivalents equivalents(double angle, double lower, double upper) {
  Equivalents result;
  const double first = angle + kTwoPi * std::ceil((lower - kLimitSlack - angle) / kTwoPi);
  for (double value = first; value <= upper + kLimitSlack && result.count < 4; value += kTwoPi)
    result.values[static_cast<std::size_t>(result.count++)] = std::clamp(value, lower, upper);
  return result;
}

/// A solution's distance from the seed, and where it stands among the others.
struct Rank {
  double max_turn = 0, sum = 0;
  std::size_t index = 0;
  bool operator<(const Rank& other) const {
    if (max_turn != other.max_turn) return max_turn < other.max_turn;
    return sum < other.sum;
  }
};

void add_equivalents(const RobotModel& robot, const IkSolution& base, std::vector<IkSolution>& all) {
  std::array<Equivalents, 6> choices;
  std::size_t combinations = 1;
  for (std::size_t i = 0; i < 6; ++i) {
    const auto j = static_cast<Eigen::Index>(i);
    choices[i] = equivalents(base.q[j], robot.lower[j], robot.upper[j]);
    combinations *= static_cast<std::size_t>(choices[i].count);
  }
  for (std::size_t k = 0; k < combinations; ++k) {
    IkSolution& solution = all.emplace_back(base);
    std::size_t rest = k;
    for (std::size_t i = 0; i < 6; ++i) {
      const auto count = static_cast<std::size_t>(choices[i].count);
      solution.q[static_cast<Eigen::Index>(i)] = choices[i].values[rest % count];
      rest /= count;
    }
  }
}

double residual(const RobotModel& robot, const Pose& T_R_F, const Joints& q) {
  return (forward(robot, q).matrix() - T_R_F.matrix()).cwiseAbs().maxCoeff();
}

/// The closed form; `wanted` is one branch, or -1 for all.
IkBranches solve(const RobotModel& robot, const Pose& T_R_F, const Joints& seed, int wanted) {
  if (!is_seed(seed)) return {};
  if (robot.calibrated) return calibrated_branches(robot, T_R_F, seed, wanted);
  IkBranches branches;
  const Target t = target_of(robot, T_R_F);
  const Shoulder shoulder = solve_shoulder(robot, t);
  if (!(shoulder.miss <= kRounding)) return branches;
  for (int shoulder_wrist = 0; shoulder_wrist < 4; ++shoulder_wrist) {
    if (wanted >= 0 && shoulder_wrist != (wanted & 3)) continue;
    const Turn& q1 = shoulder.q1[static_cast<std::size_t>(shoulder_wrist & 1)];
    Wrist wrist = solve_wrist(robot, t, q1, (shoulder_wrist & 2) != 0, seed[5] + robot.dh_offset[5]);
    Elbow elbow = solve_elbow(robot, wrist);
    const bool clamped = shoulder.miss > 0.0 || elbow.miss > 0.0;
    if (elbow.miss > 0.0) {
      turn_into_reach(robot, t, wrist);
      elbow = solve_elbow(robot, wrist);
    }
    if (!(elbow.miss <= kRounding)) continue;
    const bool rough = shoulder.miss > kClamp || elbow.miss > kClamp;
    const ArmBend bend = bend_of(robot, wrist, elbow.q3);
    for (const int down : {0, 4}) {
      if (wanted >= 0 && down != (wanted & 4)) continue;
      IkSolution found = solution(robot, wrist, bend, shoulder_wrist | down, seed);
      // Each clamp alone stays within kClamp; two of them, or a turned wrist, may not.
      const bool off = rough || (clamped && residual(robot, T_R_F, found.q) > kClamp);
      if (off && !polish(robot, T_R_F, kClamp, found.q)) continue;
      branches.solutions[static_cast<std::size_t>(branches.count++)] = found;
    }
  }
  sort_by_branch(branches);
  return branches;
}

void require_valid(const Pose& T_R_F, const Joints& seed) {
  require(is_valid(T_R_F), "inverse kinematics needs a rigid transform, got ", geometry::to_text(T_R_F));
  require(is_seed(seed), "inverse kinematics needs a seed of finite angles, at most ", kFarthest,
          " rad, got ", seed.transpose());
}

}  // namespace

IkBranches inverse_branches(const RobotModel& robot, const Pose& T_R_F, const Joints& seed) {
  return solve(robot, T_R_F, seed, -1);
}

IkOnBranch inverse_on_branch(const RobotModel& robot, const Pose& T_R_F, const Joints& seed, int branch) {
  const IkBranches branches = solve(robot, T_R_F, seed, branch);
  if (branches.count == 0) return {};
  IkOnBranch result{true, branches.solutions[0].q};
  for (Eigen::Index i = 0; i < 6; ++i) {
    const auto choices = equivalents(result.q[i], robot.lower[i], robot.upper[i]);
    if (choices.count == 0) return {};
    const auto* const end = choices.values.begin() + choices.count;
    result.q[i] = *std::min_element(choices.values.begin(), end, [&](double a, double b) {
      return std::abs(a - seed[i]) < std::abs(b - seed[i]);
    });
  }
  return result;
}

std::vector<IkSolution> inverse(const RobotModel& robot, const Pose& T_R_F, const Joints& seed) {
  require_valid(T_R_F, seed);
  const IkBranches branches = solve(robot, T_R_F, seed, -1);
  std::vector<IkSolution> all;
  all.reserve(256);
  for (int i = 0; i < branches.count; ++i)
    add_equivalents(robot, branches.solutions[static_cast<std::size_t>(i)], all);
  std::vector<Rank> ranks(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Joints away = (all[i].q - seed).cwiseAbs();
    ranks[i] = {away.maxCoeff(), away.sum(), i};
  }
  std::stable_sort(ranks.begin(), ranks.end());
  std::vector<IkSolution> solutions;
  solutions.reserve(all.size());
  for (const auto& rank : ranks) solutions.push_back(all[rank.index]);
  return solutions;
}

int branch_of(const RobotModel& robot, const Joints& q) {
  const Joints t = q + robot.dh_offset;
  // Upper arm and forearm are negative in UR's tables, so an arm that reaches forward has u < 0.
  const double u =
      robot.a2 * std::cos(t[1]) + robot.a3 * std::cos(t[1] + t[2]) + robot.d5 * std::sin(t[1] + t[2] + t[3]);
  const int shoulder = u < 0 ? 0 : 1;
  return shoulder | (std::sin(t[4]) < 0 ? 2 : 0) | (std::sin(t[2]) < 0 ? 4 : 0);
}

}  // namespace stonestack::kinematics
