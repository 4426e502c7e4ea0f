#include "stonestack/motion/jerk.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/motion/timing.hpp"

namespace stonestack {
namespace {

constexpr double kMillisecond = 0.001;

TimingLimits limits() {
  TimingLimits limits;
  limits.velocity << 1.0, 1.0, 1.5, 1.5, 1.5, 1.5;
  limits.acceleration.setConstant(1.4);
  limits.blend = 0.05;
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

/// Largest of |d3q/dt3| by third differences of positions at 1 kHz, of all joints.
double jerk_at_one_kilohertz(const JointTrajectory& t) {
  double largest = 0.0;
  std::vector<Joints> q;
  for (double s = -0.01; s < t.duration() + 0.01; s += kMillisecond) q.push_back(sample(t, s).q);
  // Over 4 ms, so that rounding does not count.
  for (std::size_t i = 12; i < q.size(); ++i) {
    const Joints third = q[i] - 3.0 * q[i - 4] + 3.0 * q[i - 8] - q[i - 12];
    largest = std::max(largest, third.cwiseAbs().maxCoeff() / std::pow(4 * kMillisecond, 3));
  }
  return largest;
}

TEST(Jerk, NoLimitIsExceededAtOneKilohertz) {
  Random random = Random::stream(3, "jerk");
  for (int k = 0; k < 20; ++k) {
    const auto fast = time_path(random_path(random, 2 + k % 9), limits());
    ASSERT_GT(jerk_at_one_kilohertz(fast), 100.0) << "there is something to limit";
    for (const double jerk : {10.0, 40.0}) {
      const auto smooth = limit_jerk(fast, jerk);
      EXPECT_LE(jerk_at_one_kilohertz(smooth), jerk);
      EXPECT_EQ(smooth.q.front(), fast.q.front());
      EXPECT_EQ(smooth.q.back(), fast.q.back());
      EXPECT_LE(smooth.duration(), fast.duration() + 1.03 * 2.0 * 1.4 / jerk);
      JointState before = sample(smooth, 0.0);
      for (double t = kMillisecond; t < smooth.duration(); t += kMillisecond) {
        const JointState now = sample(smooth, t);
        ASSERT_TRUE((now.qd.cwiseAbs().array() <= limits().velocity.array() * (1 + 1e-6)).all());
        const Joints a = (now.qd - before.qd) / kMillisecond;
        ASSERT_TRUE((a.cwiseAbs().array() <= limits().acceleration.array() * (1 + 1e-3)).all()) << t;
        before = now;
      }
    }
  }
}

/// Rest to rest on a line with one joint: acceleration ramps of a known length.
TEST(Jerk, ALineBecomesADoubleS) {
  const auto fast = time_path({Joints::Zero(), Joints::Unit(0)}, limits());
  const auto smooth = limit_jerk(fast, 14.0);
  EXPECT_EQ(limit_jerk(fast, 0.0).time, fast.time) << "0 is no limit";
  const double window = smooth.duration() - fast.duration();
  EXPECT_NEAR(window, 2 * 1.4 / 14.0, 0.03 * 2 * 1.4 / 14.0);
  // While the window fills, acceleration rises evenly: q = a t^3 / (6 window).
  for (const double t : {0.05, 0.1, 0.15})
    EXPECT_NEAR(sample(smooth, t).q[0], 1.4 * t * t * t / (6 * window), 1e-9);
}

TEST(Jerk, StaysBesideThePath) {
  Random random = Random::stream(4, "jerk");
  const auto fast = time_path(random_path(random, 8), limits());
  const double jerk = 50.0;
  const auto smooth = limit_jerk(fast, jerk);
  const double window = smooth.duration() - fast.duration();
  for (double t = 0.0; t < fast.duration(); t += 0.005) {
    const Joints off = sample(smooth, t + 0.5 * window).q - sample(fast, t).q;
    ASSERT_LE(off.cwiseAbs().maxCoeff(), 1.4 * window * window / 24.0 + 1e-9) << t;
  }
}

TEST(Jerk, WhatDoesNotMoveStays) {
  const JointTrajectory one{{0.0}, {Joints::Ones()}, {Joints::Zero()}};
  EXPECT_EQ(limit_jerk(one, 10.0).duration(), 0.0);
  EXPECT_THROW((void)limit_jerk(one, -1.0), InvalidArgument);
  EXPECT_THROW((void)limit_jerk(one, std::nan("")), InvalidArgument);
  EXPECT_THROW((void)limit_jerk({}, 10.0), InvalidArgument);
}

}  // namespace
}  // namespace stonestack
