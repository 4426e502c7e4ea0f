#include "kinematics/calibrated_inverse.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/constants.hpp"
#include "kinematics/closed_form.hpp"
#include "kinematics/polish.hpp"

namespace stonestack::kinematics {
namespace {

constexpr double kCalibration = 0.02;  // m: what a factory calibration may move
constexpr double kBeside = 0.1;        // rad: starts keep that far from where the closed form's branches meet
constexpr double kAstray = 0.5;        // rad, a joint's distance from its start: perhaps to another branch
constexpr double kSame = 1e-6;         // rad
constexpr double kWristInLine = 0.1;   // sine of wrist 2 below which wrist 3 may be anywhere
constexpr int kTurns = 8;              // of wrist 3, tried there
constexpr double kBent = 0.02;         // rad, wrist 2 then
constexpr double kMeeting = 0.6;       // rad between the base's two angles: they may be others, or one
constexpr double kAside = 0.3;         // rad, to both sides of them
constexpr double kBentElbow = 0.4;     // rad, an elbow that is tried beside kBeside
constexpr std::size_t kBranches = 8;

/// Largest difference of two joint vectors, whole turns not counted.
double apart(const Joints& a, const Joints& b) {
  double max = 0.0;
  for (Eigen::Index i = 0; i < 6; ++i) max = std::max(max, std::abs(nearest_turn(a[i] - b[i], 0.0)));
  return max;
}

class CalibratedSearch {
 public:
  CalibratedSearch(const RobotModel& robot, const Pose& T_R_F, const Joints& seed)
      : robot_(robot),
        T_R_F_(T_R_F),
        seed_(seed),
        target_(target_of(robot, T_R_F)),
        shoulder_(solve_shoulder(robot, target_, 2 * kBeside)) {}

  /// Every solution under its start's branch or, where that is uncertain, under the branch of its signs.
  [[nodiscard]] IkBranches all() {
    if (!(shoulder_.miss <= kCalibration)) return {};
    bool any_uncertain = false;
    for (const int right : {0, 1}) {
      bool uncertain = shoulder_.miss > 0.0;
      double sine = 1.0;
      for (const int flipped : {0, 2}) {
        const Wrist wrist = start_wrist(right | flipped);
        for (const int down : {0, 4})
          uncertain = !begin(wrist, right | flipped | down, 0.0, kBeside) || uncertain;
        sine = wrist.sine;
      }
      if (uncertain) search_about(right, sine);
      any_uncertain = any_uncertain || uncertain;
    }
    if (any_uncertain) name_by_signs();
    sort_by_branch(found_);
    return found_;
  }

  /// Returns that branch alone, where its start is certain; empty otherwise.
  [[nodiscard]] IkBranches one(int branch) {
    if (shoulder_.miss > 0.0) return {};
    const Wrist wrist = start_wrist(branch & 3);
    if (wrist.sine < kWristInLine || !begin(wrist, branch, 0.0, kBeside)) return {};
    return found_;
  }

 private:
  [[nodiscard]] Wrist start_wrist(int shoulder_wrist) const {
    return solve_wrist(robot_, target_, shoulder_.q1[static_cast<std::size_t>(shoulder_wrist & 1)],
                       (shoulder_wrist & 2) != 0, seed_[5] + robot_.dh_offset[5]);
  }

  /// Looks for the solution of `branch`, wrist 2 bent by `bent` more than `wrist` has it, the elbow at least
  /// by `min`. False where what it finds may not be that branch's own, or where another turn of wrist 3
  /// could bring into reach what is not.
  bool begin(const Wrist& wrist, int branch, double bent, double min) {
    Elbow elbow = solve_elbow(robot_, wrist);
    if (!(elbow.miss <= kCalibration)) return wrist.sine >= kWristInLine;
    const bool sure = elbow.miss == 0.0 && std::abs(elbow.q3.s) > std::sin(kBeside);
    elbow.q3 = turn_by(std::clamp(elbow.q3.angle, min, kPi - min));
    IkSolution found = solution(robot_, wrist, bend_of(robot_, wrist, elbow.q3), branch, seed_);
    found.q[4] += bent;
    const Joints start = found.q;
    if (!polish(robot_, T_R_F_, kClamp, found.q)) return false;
    const Joints end = found.q;
    for (int i = 0; i < 6; ++i) found.q[i] = nearest_turn(found.q[i], seed_[i]);
    for (int i = 0; i < found_.count; ++i)
      if (apart(found_.solutions[static_cast<std::size_t>(i)].q, found.q) < kSame) return false;
    if (found_.count == static_cast<int>(kBranches)) return false;
    found_.solutions[static_cast<std::size_t>(found_.count++)] = found;
    return sure && (end - start).cwiseAbs().maxCoeff() < kAstray;
  }

  /// Starts all round wrist 3 where wrist 2 is nearly in line, to both sides of the base's angle where its
  /// two solutions nearly meet, and with the elbow bent further.
  void search_about(int right, double sine) {
    const double lead = std::abs(std::remainder(shoulder_.q1[0].angle - shoulder_.q1[1].angle, 2.0 * kPi));
    const bool over_base = lead < kMeeting;
    const int turns = sine < kWristInLine ? kTurns : 1;
    for (const double aside : {0.0, kAside, -kAside}) {
      if (aside != 0.0 && !over_base) break;
      const Turn q1 = turn_by(shoulder_.q1[static_cast<std::size_t>(right)].angle + aside);
      for (const int flipped : {0, 2}) {
        Wrist wrist = solve_wrist(robot_, target_, q1, flipped != 0, seed_[5] + robot_.dh_offset[5]);
        const double first = wrist.q6;
        for (int k = 0; k < turns; ++k) {
          if (k > 0) set_tool(robot_, target_, turn_by(first + 2.0 * kPi * k / turns), wrist);
          for (const double min : {kBeside, kBentElbow})
            for (const int down : {0, 4})
              begin(wrist, right | flipped | down, turns == 1 ? 0.0 : flipped == 0 ? kBent : -kBent, min);
        }
      }
    }
  }

  /// Gives each solution the branch whose signs it has; of two with the same signs the second the free branch
  /// that differs least. Next to a singularity the axes' departures decide on which side a solution lies.
  void name_by_signs() {
    std::array<bool, kBranches> taken{}, named{};
    const auto count = static_cast<std::size_t>(found_.count);
    const auto name = [&](std::size_t i, int branch) {
      if (named[i] || taken[static_cast<std::size_t>(branch)]) return;
      found_.solutions[i].branch = branch;
      named[i] = taken[static_cast<std::size_t>(branch)] = true;
    };
    std::array<int, kBranches> signs{};
    for (std::size_t i = 0; i < count; ++i) signs[i] = branch_of(robot_, found_.solutions[i].q);
    for (std::size_t i = 0; i < count; ++i)
      if (signs[i] == found_.solutions[i].branch) name(i, signs[i]);
    for (std::size_t i = 0; i < count; ++i) name(i, signs[i]);
    for (int bits = 1; bits <= 3; ++bits)
      for (std::size_t i = 0; i < count; ++i)
        for (int other = 0; other < static_cast<int>(kBranches); ++other)
          if (std::popcount(static_cast<unsigned>(other ^ signs[i])) == bits) name(i, other);
  }

  const RobotModel& robot_;
  const Pose& T_R_F_;
  const Joints& seed_;
  const Target target_;
  const Shoulder shoulder_;
  IkBranches found_;
};

}  // namespace

IkBranches calibrated_branches(const RobotModel& robot, const Pose& T_R_F, const Joints& seed, int wanted) {
  if (wanted >= 0)
    if (const IkBranches sure = CalibratedSearch(robot, T_R_F, seed).one(wanted); sure.count > 0) return sure;
  const IkBranches all = CalibratedSearch(robot, T_R_F, seed).all();
  if (wanted < 0) return all;
  IkBranches only;
  for (int i = 0; i < all.count; ++i)
    if (all.solutions[static_cast<std::size_t>(i)].branch == wanted)
      only.solutions[static_cast<std::size_t>(only.count++)] = all.solutions[static_cast<std::size_t>(i)];
  return only;
}

void sort_by_branch(IkBranches& branches) {
  std::sort(branches.solutions.begin(), branches.solutions.begin() + branches.count,
            [](const IkSolution& a, const IkSolution& b) { return a.branch < b.branch; });
}

}  // namespace stonestack::kinematics
