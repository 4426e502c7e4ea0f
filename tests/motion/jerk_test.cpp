#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "kinematics/inverse.hpp"
#include "motion/hard_scene.hpp"
#include "motion/timing.hpp"
#include "motion/transit.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

constexpr double kMillisecond = 0.001;

TimingLimits limits_with(double jerk) {
  TimingLimits limits;
  limits.velocity << 1.0, 1.0, 1.5, 1.5, 1.5, 1.5;
  limits.acceleration.setConstant(1.4);
  limits.blend = 0.05;
  limits.jerk = jerk;
  return limits;
}

JointPath random_path(Random& random, int points) {
  JointPath path;
  for (int i = 0; i < points; ++i) {
    Joints q;
    for (auto& angle : q) angle = random.uniform(-1.5, 1.5);
    path.push_back(q);
  }
  return path;
}

/// Largest velocity, acceleration and jerk over their limits, by differences of samples at 1 kHz.
Joints excess(const JointTrajectory& t, const TimingLimits& limits) {
  double v = 0.0, a = 0.0, j = 0.0;
  Joints speed = Joints::Zero(), acceleration = Joints::Zero();
  for (double at = kMillisecond; at < t.duration() + 3 * kMillisecond; at += kMillisecond) {
    const Joints now = (sample(t, at).q - sample(t, at - kMillisecond).q) / kMillisecond;
    const Joints gain = (now - speed) / kMillisecond;
    v = std::max(v, now.cwiseAbs().cwiseQuotient(limits.velocity).maxCoeff());
    a = std::max(a, gain.cwiseAbs().cwiseQuotient(limits.acceleration).maxCoeff());
    if (limits.jerk > 0)
      j = std::max(j, (gain - acceleration).cwiseAbs().maxCoeff() / kMillisecond / limits.jerk);
    speed = now;
    acceleration = gain;
  }
  return (Joints() << v, a, j, 0, 0, 0).finished();
}

void expect_within(const JointTrajectory& t, const TimingLimits& limits, double jerk) {
  const Joints over = excess(t, limits);
  EXPECT_LE(over[0], 1 + 1e-6) << jerk;
  EXPECT_LE(over[1], 1 + 1e-6) << jerk;
  EXPECT_LE(over[2], 1 + 1e-3) << jerk << ", differences of positions over 1 ms, with their rounding";
}

TEST(Jerk, NoLimitIsExceededAtOneKilohertz) {
  Random random = Random::stream(3, "jerk");
  for (int k = 0; k < 20; ++k) {
    const JointPath path = random_path(random, 2 + k % 9);
    TimingLimits loose = limits_with(40.0);
    loose.jerk = 0.0;
    const auto fast = time_path(path, loose);
    loose.jerk = 40.0;
    ASSERT_GT(excess(fast, loose)[2], 2.0) << "there is something to limit";
    for (const double jerk : {1.0, 10.0, 40.0}) {
      const auto smooth = time_path(path, limits_with(jerk));
      expect_within(smooth, limits_with(jerk), jerk);
      EXPECT_EQ(smooth.q.front(), path.front());
      EXPECT_LT((smooth.q.back() - path.back()).norm(), 1e-12);
      EXPECT_EQ(smooth.qd.back(), Joints::Zero());
      EXPECT_GT(smooth.duration(), fast.duration());
    }
  }
}

/// Rest to rest on a line with one joint: ramps of acceleration, a hold, a cruise and the same back.
TEST(Jerk, ALineBecomesADoubleS) {
  const double jerk = 14.0, a = 1.4, v = 1.0;
  const auto smooth = time_path({Joints::Zero(), 2 * Joints::Unit(0)}, limits_with(jerk));
  EXPECT_NEAR(smooth.duration(), 2.0 / v + v / a + a / jerk, 1e-9);
  for (const double t : {0.02, 0.05, 0.1}) EXPECT_NEAR(sample(smooth, t).q[0], jerk * t * t * t / 6, 1e-9);
}

double distance(const Joints& q, const Joints& a, const Joints& b) {
  const double length = (b - a).squaredNorm();
  const double s = length > 0 ? std::clamp((q - a).dot(b - a) / length, 0.0, 1.0) : 0.0;
  return (q - a - s * (b - a)).norm();
}

/// The certified path is the one that is driven: the jerk limit changes the law of time only.
TEST(Jerk, StaysOnTheRoundedPath) {
  Random random = Random::stream(4, "jerk");
  const JointPath path = random_path(random, 8);
  for (const double jerk : {50.0, 5.0, 1.0}) {
    const JointPath certified = rounded(path, limits_with(jerk), 0.01);
    const auto smooth = time_path(path, limits_with(jerk));
    for (double t = 0.0; t < smooth.duration(); t += 0.01) {
      const Joints q = sample(smooth, t).q;
      double off = 1.0;
      for (std::size_t i = 1; i < certified.size(); ++i)
        off = std::min(off, distance(q, certified[i - 1], certified[i]));
      ASSERT_LE(off, 1.1e-5) << "jerk " << jerk << " at " << t;
    }
  }
}

TEST(Jerk, KeepsTheToolSpeed) {
  const RobotModel robot = read_robot("ur10");
  const Pose T_F_T(Eigen::Translation3d(0, 0, 0.264));
  Random random = Random::stream(5, "jerk");
  TimingLimits limits = limits_with(5.0);
  limits.tool_speed = 0.1;
  for (int k = 0; k < 3; ++k) {
    const auto smooth = time_path(random_path(random, 4), limits, robot, T_F_T);
    expect_within(smooth, limits, 5.0);
    const auto tool = [&](double t) {
      return (forward(robot, sample(smooth, t).q) * T_F_T).translation().eval();
    };
    for (double t = 0.01; t < smooth.duration(); t += 0.01)
      ASSERT_LE((tool(t) - tool(t - kMillisecond)).norm() / kMillisecond, 0.1001);
  }
}

/// Averaging the joints over time cut corners unseen: 3 to 35 mm into the towers.
TEST(Jerk, ATransitKeepsItsPaddingOnTheHardSet) {
  const PlanningScene scene = test::hard_scene();
  CollisionRules rules;
  const CollisionChecker posed(scene, rules);
  rules.padding -= 3e-5;  // chords of the curves are certified, the curves lie within 0.01 mrad of them
  rules.self_padding -= 3e-5;
  const CollisionChecker checker(scene, rules);
  Random random = Random::stream(7, "transit problems");
  int tested = 0;
  while (tested < 6) {
    const auto place = [&](double low, double high) {
      return Eigen::Vector3d(random.uniform(0.55, 0.95), random.uniform(low, high), random.uniform(0.1, 0.3));
    };
    const auto starts = test::tool_down_at(scene, place(-0.45, -0.2), random.uniform(-kPi, kPi));
    const auto goals = test::tool_down_at(scene, place(0.3, 0.5), random.uniform(-kPi, kPi));
    if (starts.empty() || goals.empty()) continue;
    if (posed.collides(starts.front()) || posed.collides(goals.front())) continue;
    ++tested;
    for (const double jerk : {0.0, 50.0, 5.0, 2.0, 1.0}) {
      MotionOptions options;
      options.jerk = jerk;
      const auto motion = plan_transit(scene, starts.front(), goals.front(), options);
      ASSERT_TRUE(motion.has_value());
      expect_within(*motion, timing_limits(scene.robot, options), jerk);
      for (double t = 0.0; t < motion->duration(); t += kMillisecond)
        ASSERT_FALSE(checker.collides(sample(*motion, t).q)) << "jerk " << jerk << " at " << t;
    }
  }
}

TEST(Jerk, AJointAtRestStaysAtRest) {
  EXPECT_EQ(time_path({Joints::Ones()}, limits_with(10.0)).duration(), 0.0);
  EXPECT_THROW((void)time_path({Joints::Ones()}, limits_with(-1.0)), InvalidArgument);
  EXPECT_THROW((void)time_path({Joints::Ones()}, limits_with(std::nan(""))), InvalidArgument);
}

TEST(Jerk, RefusesLimitsWithWhichNothingMoves) {
  MotionOptions options;
  options.jerk = 0.001;
  EXPECT_THROW((void)timing_limits(read_robot("ur10"), options), InvalidArgument);
  options.jerk = 1.0;
  EXPECT_EQ(timing_limits(read_robot("ur10"), options).jerk, 1.0);
}

}  // namespace
}  // namespace stonestack::motion
