#include "kinematics/inverse.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "core/constants.hpp"
#include "kinematics/dh.hpp"
#include "kinematics/jacobian.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::kinematics {
namespace {

Joints random_joints(const RobotModel& robot, Random& random) {
  Joints q;
  for (Eigen::Index i = 0; i < 6; ++i) q[i] = random.uniform(robot.lower[i], robot.upper[i]);
  return q;
}

/// Largest entry of the difference: metres and, for small angles, radians. Without the cancellation of acos.
double residual(const RobotModel& robot, const Joints& q, const Pose& T_R_F) {
  return (forward(robot, q).matrix() - T_R_F.matrix()).cwiseAbs().maxCoeff();
}

/// Difference of two configurations up to whole turns.
double apart(const Joints& a, const Joints& b) {
  double worst = 0.0;
  for (Eigen::Index i = 0; i < 6; ++i)
    worst = std::max(worst, std::abs(std::remainder(a[i] - b[i], 2 * kPi)));
  return worst;
}

TEST(Inverse, RecoversRandomConfigurationsOfEveryRobot) {
  for (const auto& name : robot_names()) {
    const RobotModel robot = read_robot(name);
    Random random = Random::stream(11, name);
    int recovered = 0;
    double worst = 0.0;
    const int count = name == "ur10" ? 100000 : 20000;
    for (int k = 0; k < count; ++k) {
      const Joints q = random_joints(robot, random);
      const Pose T_R_F = forward(robot, q);
      const IkBranches branches = inverse_branches(robot, T_R_F, q);
      bool found = false;
      for (int i = 0; i < branches.count; ++i) {
        const auto& s = branches.solutions[static_cast<std::size_t>(i)];
        worst = std::max(worst, s.q.allFinite() ? residual(robot, s.q, T_R_F) : 1e9);
        found = found || (s.q - q).cwiseAbs().maxCoeff() < 1e-5;
      }
      recovered += found ? 1 : 0;
    }
    EXPECT_EQ(recovered, count) << name;
    EXPECT_LE(worst, 1e-9) << name;
  }
}

TEST(Inverse, EverySolutionOfEveryBranchMeetsThePoseWithinLimits) {
  for (const auto& name : robot_names()) {
    const RobotModel robot = read_robot(name);
    Random random = Random::stream(12, name);
    for (int k = 0; k < 200; ++k) {
      const Joints q = random_joints(robot, random);
      const Pose T_R_F = forward(robot, q);
      const auto solutions = inverse(robot, T_R_F, q);
      ASSERT_FALSE(solutions.empty());
      EXPECT_LT((solutions.front().q - q).cwiseAbs().maxCoeff(), 1e-5) << "the nearest to the seed is first";
      double last = 0.0;
      for (const auto& s : solutions) {
        EXPECT_LE(residual(robot, s.q, T_R_F), 1e-9);
        EXPECT_TRUE((s.q.array() >= robot.lower.array()).all() && (s.q.array() <= robot.upper.array()).all());
        EXPECT_EQ(branch_of(robot, s.q), s.branch);
        const double away = (s.q - q).cwiseAbs().maxCoeff();
        EXPECT_GE(away, last);
        last = away;
      }
    }
  }
}

TEST(Inverse, GivesEveryTurnWithinLimits) {
  const RobotModel robot = read_robot("ur10");
  Joints q;
  q << 0.5, -1.2, 1.4, -1.0, -1.5, 0.4;
  const auto solutions = inverse(robot, forward(robot, q), Joints::Zero());
  // Five joints may turn once more, the elbow may not: 2^5 a branch.
  std::set<int> branches;
  for (const auto& s : solutions) branches.insert(s.branch);
  EXPECT_EQ(branches.size(), 8u);
  EXPECT_EQ(solutions.size(), 8u * 32u);
  const auto has = [&](const Joints& wanted) {
    return std::any_of(solutions.begin(), solutions.end(),
                       [&](const auto& s) { return (s.q - wanted).cwiseAbs().maxCoeff() < 1e-9; });
  };
  for (const Eigen::Index i : {0, 1, 3, 4, 5}) {
    Joints other = q;
    other[i] += q[i] > 0 ? -2 * kPi : 2 * kPi;
    EXPECT_TRUE(has(other)) << "joint " << i;
  }
}

/// Elbow straight or folded, wrist in line, wrist centre on the shoulder's axis, and pairs of them, at and
/// around the exact values.
TEST(Inverse, MeetsSingularPosesWithoutNan) {
  for (const auto& name : robot_names()) {
    const RobotModel robot = read_robot(name);
    Random random = Random::stream(13, name);
    double worst = 0.0;
    int empty = 0;
    for (int k = 0; k < 2000; ++k) {
      Joints q = random_joints(robot, random);
      const double offsets[] = {0.0, 1e-15, -1e-13, 1e-11, -1e-10, 1e-9, -1e-8, 1e-7, 1e-6, -1e-4};
      const double near = offsets[random.index(10)];
      if ((k & 1) != 0) q[4] = near + (random.uniform() < 0.5 ? 0.0 : kPi);
      if ((k & 2) != 0) q[2] = random.uniform() < 0.5 ? near : kPi - std::abs(near);
      if ((k & 4) != 0) {  // bring the wrist's centre into the plane through the base axis: u = 0
        const double q234 = q[1] + q[2] + q[3];
        const double u = robot.a2 * std::cos(q[1]) + robot.a3 * std::cos(q[1] + q[2]);
        if (std::abs(u) < robot.d5) q[3] += std::asin(-u / robot.d5) - q234 + near;
      }
      const Pose T_R_F = forward(robot, q);
      const auto solutions = inverse(robot, T_R_F, random_joints(robot, random));
      empty += solutions.empty() ? 1 : 0;
      for (const auto& s : solutions)
        worst = std::max(worst, s.q.allFinite() ? residual(robot, s.q, T_R_F) : 1e9);
    }
    EXPECT_EQ(empty, 0) << name;
    EXPECT_LE(worst, 1e-9) << name;
  }
}

/// Wrist in line, elbow nearly stretched and wrist over the base, each beside it by another amount: what
/// rounding leaves of the base's angle makes wrist 3 a guess, which may put wrist 1 out of reach.
TEST(Inverse, MeetsPosesNearThreeSingularitiesAtOnce) {
  constexpr std::array kBeside{0.0, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3};
  for (const auto& name : robot_names()) {
    const RobotModel robot = read_robot(name);
    Random random = Random::stream(14, name);
    const auto beside = [&] {
      return (random.uniform() < 0.5 ? -1 : 1) * kBeside[random.index(kBeside.size())];
    };
    double worst = 0.0;
    int empty = 0;
    for (int k = 0; k < 6000; ++k) {
      Joints q = random_joints(robot, random);
      q[4] = (random.uniform() < 0.5 ? 0.0 : kPi) + beside();
      q[2] = beside();
      const double c = robot.a2 + robot.a3 * std::cos(q[2]) + robot.d5 * std::sin(q[2] + q[3]);
      const double s = -robot.a3 * std::sin(q[2]) + robot.d5 * std::cos(q[2] + q[3]);
      q[1] = std::atan2(-c, s) + (random.uniform() < 0.5 ? 0.0 : kPi) + beside();  // down or up
      const Pose T_R_F = forward(robot, q);
      const auto found = inverse_branches(robot, T_R_F, random_joints(robot, random));
      empty += found.count == 0 ? 1 : 0;
      for (int i = 0; i < found.count; ++i) {
        const Joints& solution = found.solutions[static_cast<std::size_t>(i)].q;
        worst = std::max(worst, solution.allFinite() ? residual(robot, solution, T_R_F) : 1e9);
      }
    }
    EXPECT_EQ(empty, 0) << name;
    EXPECT_LE(worst, 1e-9) << name;
  }
}

TEST(Inverse, TakesTheFreeWristAngleFromTheSeed) {
  const RobotModel robot = read_robot("ur10");
  Joints q;
  q << 0.5, -1.2, 1.4, -1.0, 0.0, 0.4;
  Joints seed = q;
  seed[5] = -1.1;
  const auto solutions = inverse(robot, forward(robot, q), seed);
  ASSERT_FALSE(solutions.empty());
  EXPECT_NEAR(solutions.front().q[5], -1.1, 1e-12);
}

TEST(Inverse, IsEmptyOutOfReach) {
  const RobotModel robot = read_robot("ur10");
  Pose T_R_F = Pose::Identity();
  T_R_F.translation() = Eigen::Vector3d(2.0, 0.0, 0.5);
  EXPECT_TRUE(inverse(robot, T_R_F, Joints::Zero()).empty());
  T_R_F.translation() = Eigen::Vector3d(0.01, 0.0, 0.5);  // inside the shoulder's cylinder of radius d4
  EXPECT_TRUE(inverse(robot, T_R_F, Joints::Zero()).empty());
}

TEST(Inverse, RefusesWhatIsNoPose) {
  const RobotModel robot = read_robot("ur10");
  Pose bad = Pose::Identity();
  bad.translation().x() = std::nan("");
  EXPECT_THROW((void)inverse(robot, bad, Joints::Zero()), InvalidArgument);
  EXPECT_THROW((void)inverse(robot, Pose::Identity(), Joints::Constant(std::nan(""))), InvalidArgument);
}

TEST(Inverse, HasNoBranchForASeedThatIsNoAngle) {
  const RobotModel robot = read_robot("ur10");
  Joints q;
  q << 0.1, -1.0, 1.0, -1.0, -1.0, 0.3;
  const Pose T_R_F = forward(robot, q);
  for (const double bad : {std::nan(""), HUGE_VAL, 1e300}) {
    Joints seed = q;
    seed[2] = bad;
    EXPECT_EQ(inverse_branches(robot, T_R_F, seed).count, 0) << bad;
    EXPECT_FALSE(inverse_on_branch(robot, T_R_F, seed, branch_of(robot, q)).found) << bad;
    EXPECT_THROW((void)inverse(robot, T_R_F, seed), InvalidArgument) << bad;
  }
}

TEST(Inverse, FollowsOneBranchAlongALine) {
  const RobotModel robot = read_robot("ur5e");
  Joints q;
  q << 0.5, -1.2, 1.4, -1.7, -1.5, 0.4;
  const int branch = branch_of(robot, q);
  Pose T_R_F = forward(robot, q);
  for (int k = 0; k < 100; ++k) {
    T_R_F.translation().z() -= 0.001;
    const auto next = inverse_on_branch(robot, T_R_F, q, branch);
    ASSERT_TRUE(next.found);
    EXPECT_LT((next.q - q).cwiseAbs().maxCoeff(), 0.02) << "a jump at step " << k;
    EXPECT_LE(residual(robot, next.q, T_R_F), 1e-9);
    q = next.q;
  }
}

/// A factory calibration moves frames by tenths of a millimetre and of a degree; the result must meet the
/// calibrated chain, not the table.
TEST(Inverse, MeetsTheChainOfACalibratedRobot) {
  RobotModel robot = read_robot("ur10");
  Random random = Random::stream(14, "calibration");
  for (auto& T : robot.T_parent_joint) {
    T.translation() += 0.0005 * random.unit_vector();
    T.rotate(Eigen::AngleAxisd(0.002, random.unit_vector()));
  }
  ASSERT_EQ(derive_dh(robot), "");
  ASSERT_TRUE(robot.calibrated);
  int recovered = 0;
  int tried = 0;
  constexpr int kCount = 2000;
  for (int k = 0; k < kCount; ++k) {
    const Joints q = random_joints(robot, random);
    if (manipulability(robot, q) < 0.01) continue;  // there a branch may not exist on the nominal table
    ++tried;
    const Pose T_R_F = forward(robot, q);
    const IkBranches branches = inverse_branches(robot, T_R_F, q);
    bool found = false;
    for (int i = 0; i < branches.count; ++i) {
      const auto& s = branches.solutions[static_cast<std::size_t>(i)];
      EXPECT_LE(residual(robot, s.q, T_R_F), 1e-9);
      found = found || apart(s.q, q) < 1e-6;
    }
    recovered += found ? 1 : 0;
  }
  EXPECT_GT(tried, kCount / 2);
  EXPECT_EQ(recovered, tried);
}

}  // namespace
}  // namespace stonestack::kinematics
