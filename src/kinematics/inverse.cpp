#include "stonestack/kinematics/inverse.hpp"

#include <algorithm>
#include <cmath>

#include "kinematics/polish.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/forward.hpp"

namespace stonestack {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kTurn = 2.0 * kPi;
constexpr double kClamp = 5e-10;    // m: how far outside the reach a pose may lie and still be met
constexpr double kRounding = 1e-5;  // m: what rounding may make of a reachable pose where singularities meet
constexpr double kCalibration = 0.02;  // m: what a factory calibration may move
constexpr double kFreeWrist = 1e-10;   // sine of wrist 2 below which wrist 3 is free
constexpr double kLimitSlack = 1e-9;   // rad: an angle this far outside its limit is set onto it

/// Pose of the last DH frame, and the wrist's centre, in the DH base.
struct Target {
  Eigen::Vector3d x, y, z;
  Eigen::Vector3d p_wrist;  ///< origin of DH frame 5
};

Target target_of(const RobotModel& robot, const Pose& T_R_F) {
  const Eigen::Matrix3d R_6_F = robot.T_D6_F.linear();
  const Eigen::Matrix3d R_D_R = robot.T_R_D.linear().transpose();
  const Eigen::Matrix3d R_D_F = R_D_R * T_R_F.linear();
  const Eigen::Matrix3d R = R_D_F * R_6_F.transpose();
  const Eigen::Vector3d p_D_F = R_D_R * (T_R_F.translation() - robot.T_R_D.translation());
  Target target{R.col(0), R.col(1), R.col(2), {}};
  target.p_wrist = p_D_F - R * robot.T_D6_F.translation() - robot.d6 * target.z;
  return target;
}

/// An angle, and by how much (m) the target was out of its reach.
struct Clamped {
  double angle = 0;
  double miss = 0;
};

/// Angle whose sine is side / length.
Clamped clamped_asin(double side, double length) {
  if (std::abs(side) <= length) return {length > 0 ? std::asin(side / length) : 0.0, 0.0};
  return {std::copysign(0.5 * kPi, side), std::abs(side) - length};
}

/// An angle with its cosine and sine, so that neither is worked out twice.
struct Turn {
  double angle = 0;
  double c = 1, s = 0;
};
Turn turn_by(double angle) {
  return {angle, std::cos(angle), std::sin(angle)};
}

/// Wrist angles and the arm's plane for one shoulder angle.
struct Wrist {
  Turn q1, q5;
  double q6 = 0;
  double sine = 0;      ///< |sin q5|
  double q234 = 0;      ///< direction of the hand in the arm's plane
  double u = 0, v = 0;  ///< wrist 1 in the arm's plane, from the shoulder
};

/// The arm's plane when the flange is turned by `q6` on wrist 3.
void set_hand(const RobotModel& robot, const Target& t, const Turn& q6, Wrist& wrist) {
  wrist.q6 = q6.angle;
  const Eigen::Vector3d z4 = -(q6.s * t.x + q6.c * t.y);
  const Eigen::Vector3d x5 = q6.c * t.x - q6.s * t.y;
  const Eigen::Vector3d x4 = wrist.q5.c * x5 - wrist.q5.s * t.z;
  const Eigen::Vector3d p = t.p_wrist - robot.d5 * z4;
  wrist.q234 = std::atan2(x4.z(), wrist.q1.c * x4.x() + wrist.q1.s * x4.y());
  wrist.u = wrist.q1.c * p.x() + wrist.q1.s * p.y();
  wrist.v = p.z() - robot.d1;
}

Wrist solve_wrist(const RobotModel& robot, const Target& t, const Turn& q1, bool flipped,
                  double q6_when_free) {
  const Eigen::Vector3d n(q1.s, -q1.c, 0.0);  // axes of shoulder, elbow and wrist 1
  // In the last frame this direction reads (s5 c6, -s5 s6, c5).
  const double nx = n.dot(t.x);
  const double ny = n.dot(t.y);
  const double nz = n.dot(t.z);
  Wrist wrist;
  wrist.q1 = q1;
  wrist.sine = std::sqrt(nx * nx + ny * ny);
  const double s5 = flipped ? -wrist.sine : wrist.sine;
  const double length = std::sqrt(s5 * s5 + nz * nz);
  wrist.q5 = {std::atan2(s5, nz), nz / length, s5 / length};
  if (wrist.sine < kFreeWrist) {
    set_hand(robot, t, turn_by(q6_when_free), wrist);
  } else {
    const double c6 = nx / s5, s6 = -ny / s5;
    set_hand(robot, t, {std::atan2(s6, c6), c6, s6}, wrist);
  }
  return wrist;
}

/// Elbow angle in [0, pi], and by how much (m) the target was out of its reach.
struct Elbow {
  Turn q3;
  double miss = 0;
};

Elbow solve_elbow(const RobotModel& robot, const Wrist& wrist) {
  const double reach2 = wrist.u * wrist.u + wrist.v * wrist.v;
  const double both = 2.0 * robot.a2 * robot.a3;
  const double cosine = (reach2 - robot.a2 * robot.a2 - robot.a3 * robot.a3) / both;
  if (std::abs(cosine) <= 1.0) {
    const double sine = std::sqrt((1.0 - cosine) * (1.0 + cosine));
    return {{std::atan2(sine, cosine), cosine, sine}, 0.0};
  }
  const double limit = std::abs(cosine > 0 ? robot.a2 + robot.a3 : robot.a2 - robot.a3);
  return {cosine > 0 ? Turn{} : Turn{kPi, -1.0, 0.0}, std::abs(std::sqrt(reach2) - limit)};
}

/// With wrist 2 in line, wrist 3 is free or nearly so, and its value (the seed's, or what rounding left of
/// it) may put wrist 1 out of reach although another one does not. Turns it to the nearest that reaches, if
/// that moves the flange by less than kClamp.
void turn_into_reach(const RobotModel& robot, const Target& t, Wrist& wrist) {
  const double u5 = wrist.q1.c * t.p_wrist.x() + wrist.q1.s * t.p_wrist.y();
  const double v5 = t.p_wrist.z() - robot.d1;
  const double far = std::hypot(u5, v5);
  const bool outside = wrist.u * wrist.u + wrist.v * wrist.v > robot.a2 * robot.a2 + robot.a3 * robot.a3;
  const double limit = std::abs(outside ? robot.a2 + robot.a3 : robot.a2 - robot.a3);
  const double cosine =
      (limit * limit - far * far - robot.d5 * robot.d5) / (2.0 * std::max(1e-12, far * std::abs(robot.d5)));
  const double half = std::acos(std::clamp(cosine, -1.0, 1.0));
  const double heading = std::atan2(v5, u5);
  const double now = std::atan2(wrist.v - v5, wrist.u - u5);
  const double one = std::remainder(heading + half - now, kTurn);
  const double other = std::remainder(heading - half - now, kTurn);
  const double turn = std::abs(one) <= std::abs(other) ? one : other;
  if (wrist.sine * std::abs(turn) > kClamp) return;
  set_hand(robot, t, turn_by(wrist.q6 + (wrist.q5.c > 0.0 ? -turn : turn)), wrist);
}

/// The equivalent of `angle` nearest to `seed`.
double near(double angle, double seed) {
  if (std::abs(angle - seed) <= kPi) return angle;
  return angle - kTurn * std::round((angle - seed) / kTurn);
}

/// `q2` and `q3` as DH angles.
IkSolution solution(const RobotModel& robot, const Wrist& wrist, double q2, double q3, int branch,
                    const Joints& seed) {
  IkSolution result;
  result.branch = branch;
  result.q << wrist.q1.angle, q2, q3, wrist.q234 - q2 - q3, wrist.q5.angle, wrist.q6;
  result.q -= robot.dh_offset;
  for (int i = 0; i < 6; ++i) result.q[i] = near(result.q[i], seed[i]);
  return result;
}

/// The values of angle + 2 pi k within the limits; at most four, for limits within a turn either way.
struct Equivalents {
  std::array<double, 4> values{};
  int count = 0;
};

Equivalents equivalents(double angle, double lower, double upper) {
  Equivalents result;
  const double first = angle + kTurn * std::ceil((lower - kLimitSlack - angle) / kTurn);
  for (double value = first; value <= upper + kLimitSlack && result.count < 4; value += kTurn)
    result.values[static_cast<std::size_t>(result.count++)] = std::clamp(value, lower, upper);
  return result;
}

/// A solution's distance from the seed, and where it stands among the others.
struct Rank {
  double largest = 0, sum = 0;
  std::size_t index = 0;
  bool operator<(const Rank& other) const {
    if (largest != other.largest) return largest < other.largest;
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
  IkBranches branches;
  const double coarse = robot.calibrated ? kCalibration : kRounding;
  const Target t = target_of(robot, T_R_F);
  const Clamped lead = clamped_asin(robot.d4, std::hypot(t.p_wrist.x(), t.p_wrist.y()));
  if (!(lead.miss <= coarse)) return branches;
  const double heading = std::atan2(t.p_wrist.y(), t.p_wrist.x());
  // The wrist lies d4 beside the arm's plane: r sin(q1 - heading) = d4.
  const std::array<Turn, 2> shoulder{turn_by(heading + kPi - lead.angle), turn_by(heading + lead.angle)};
  for (int shoulder_wrist = 0; shoulder_wrist < 4; ++shoulder_wrist) {
    if (wanted >= 0 && shoulder_wrist != (wanted & 3)) continue;
    const Turn& q1 = shoulder[static_cast<std::size_t>(shoulder_wrist & 1)];
    Wrist wrist = solve_wrist(robot, t, q1, (shoulder_wrist & 2) != 0, seed[5] + robot.dh_offset[5]);
    Elbow elbow = solve_elbow(robot, wrist);
    const bool clamped = lead.miss > 0.0 || elbow.miss > 0.0;
    if (elbow.miss > 0.0) {
      turn_into_reach(robot, t, wrist);
      elbow = solve_elbow(robot, wrist);
    }
    if (!(elbow.miss <= coarse)) continue;
    const bool rough = robot.calibrated || lead.miss > kClamp || elbow.miss > kClamp;
    const Turn& q3 = elbow.q3;
    const double rise = std::atan2(wrist.v, wrist.u);
    const double bend = std::atan2(robot.a3 * q3.s, robot.a2 + robot.a3 * q3.c);
    for (const int down : {0, 4}) {
      if (wanted >= 0 && down != (wanted & 4)) continue;
      const double sign = down == 0 ? 1.0 : -1.0;
      const double q2 = rise - sign * bend;
      IkSolution found = solution(robot, wrist, q2, sign * q3.angle, shoulder_wrist | down, seed);
      // Each clamp alone stays within kClamp; two of them, or a turned wrist, may not.
      const bool off = rough || (clamped && residual(robot, T_R_F, found.q) > kClamp);
      if (off && !polish(robot, T_R_F, kClamp, found.q)) continue;
      branches.solutions[static_cast<std::size_t>(branches.count++)] = found;
    }
  }
  std::sort(branches.solutions.begin(), branches.solutions.begin() + branches.count,
            [](const IkSolution& a, const IkSolution& b) { return a.branch < b.branch; });
  return branches;
}

void require_valid(const Pose& T_R_F, const Joints& seed) {
  require(is_valid(T_R_F), "inverse kinematics needs a rigid transform, got ", to_text(T_R_F));
  require(seed.allFinite(), "inverse kinematics needs a finite seed, got ", seed.transpose());
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

}  // namespace stonestack
