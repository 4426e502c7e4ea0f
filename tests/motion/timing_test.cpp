#include "motion/timing.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "motion/path/min_time.hpp"
#include "motion/path/smooth_path.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

TimingLimits ur10_limits() {
  TimingLimits limits;
  limits.velocity << 1.05, 1.05, 1.57, 1.57, 1.57, 1.57;
  limits.acceleration.setConstant(1.4);
  return limits;
}

JointPath random_path(Random& random, std::size_t count) {
  JointPath path(count);
  for (Joints& q : path)
    for (int j = 0; j < 6; ++j) q[j] = random.uniform(-2.0, 2.0);
  return path;
}

/// Position and velocity of the cubic piece that holds `t`, worked out here so that the test does not lean on
/// `sample`.
JointState hermite(const JointTrajectory& trajectory, double t) {
  std::size_t i = 0;
  while (i + 2 < trajectory.time.size() && trajectory.time[i + 1] < t) ++i;
  const double dt = trajectory.time[i + 1] - trajectory.time[i];
  const double u = std::clamp((t - trajectory.time[i]) / dt, 0.0, 1.0);
  const Joints &q0 = trajectory.q[i], &q1 = trajectory.q[i + 1];
  const Joints m0 = dt * trajectory.qd[i], m1 = dt * trajectory.qd[i + 1];
  const Joints a = 2 * (q0 - q1) + m0 + m1, b = 3 * (q1 - q0) - 2 * m0 - m1;
  return {a * u * u * u + b * u * u + m0 * u + q0, (3 * a * u * u + 2 * b * u + m0) / dt};
}

double distance_to_polyline(const JointPath& path, const Joints& q) {
  double nearest = 1e300;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const Joints d = path[i + 1] - path[i];
    const double s = std::clamp((q - path[i]).dot(d) / d.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (q - path[i] - s * d).norm());
  }
  return nearest;
}

TEST(Timing, SingleJointLineIsATrapezoid) {
  TimingLimits limits = ur10_limits();
  JointPath path(2, Joints::Zero());
  path[1][0] = 2.0;
  const double v = 1.05, a = 1.4;
  EXPECT_NEAR(time_path(path, limits).duration(), 2.0 / v + v / a, 1e-6);
  path[1][0] = 0.1;  // never reaches full speed
  EXPECT_NEAR(time_path(path, limits).duration(), 2 * std::sqrt(0.1 / a), 1e-6);
}

TEST(Timing, StartsAndEndsAtRestOnTheWaypoints) {
  Random random(3);
  const JointPath path = random_path(random, 6);
  const JointTrajectory t = time_path(path, ur10_limits());
  EXPECT_EQ(t.q.front(), path.front());
  EXPECT_LT((t.q.back() - path.back()).norm(), 1e-12);
  EXPECT_EQ(t.qd.front().norm(), 0.0);
  EXPECT_LT(t.qd.back().norm(), 1e-9);
  for (std::size_t i = 0; i + 1 < t.time.size(); ++i) EXPECT_LT(t.time[i], t.time[i + 1]);
}

TEST(Timing, NoLimitIsExceededAtOneKilohertz) {
  const TimingLimits limits = ur10_limits();
  for (int trial = 0; trial < 40; ++trial) {
    Random random = Random::stream(7, static_cast<std::uint64_t>(trial));
    TimingLimits l = limits;
    l.blend = std::array{0.0, 0.005, 0.05, 0.3}[static_cast<std::size_t>(trial) % 4];
    const JointTrajectory t = time_path(random_path(random, 2 + random.index(9)), l);
    JointState last = hermite(t, 0.0);
    for (double time = 0.001; time <= t.duration(); time += 0.001) {
      const JointState now = hermite(t, time);
      ASSERT_LE((now.qd.cwiseAbs().cwiseQuotient(l.velocity)).maxCoeff(), 1.0 + 1e-6) << trial << " " << time;
      const Joints acceleration = (now.qd - last.qd) / 0.001;
      ASSERT_LE(acceleration.cwiseAbs().cwiseQuotient(l.acceleration).maxCoeff(), 1.0 + 1e-6)
          << trial << " " << time;
      last = now;
    }
  }
}

TEST(Timing, StaysWithinTheBlendOfThePath) {
  for (int trial = 0; trial < 10; ++trial) {
    Random random = Random::stream(8, static_cast<std::uint64_t>(trial));
    TimingLimits limits = ur10_limits();
    limits.blend = 0.02;
    const JointPath path = random_path(random, 6);
    const JointTrajectory t = time_path(path, limits);
    for (double time = 0.0; time <= t.duration(); time += 0.004)
      ASSERT_LE(distance_to_polyline(path, hermite(t, time).q), limits.blend + 1e-4);
    for (const Joints& q : rounded(path, limits, 0.01))
      ASSERT_LE(distance_to_polyline(path, q), limits.blend + 1e-9);
  }
}

/// A time-optimal motion has a joint at a velocity or acceleration limit at (almost) every instant (Bobrow,
/// Dubowsky and Gibson 1985).
TEST(Timing, SomeLimitIsActiveAllTheTime) {
  for (int trial = 0; trial < 10; ++trial) {
    Random random = Random::stream(9, static_cast<std::uint64_t>(trial));
    TimingLimits limits = ur10_limits();
    limits.blend = 0.05;
    const JointTrajectory t = time_path(random_path(random, 10), limits);
    double active = 0.0;
    JointState last = hermite(t, 0.0);
    for (double time = 0.001; time <= t.duration(); time += 0.001) {
      const JointState now = hermite(t, time);
      const double v = now.qd.cwiseAbs().cwiseQuotient(limits.velocity).maxCoeff();
      const double a = ((now.qd - last.qd) / 0.001).cwiseAbs().cwiseQuotient(limits.acceleration).maxCoeff();
      if (std::max(v, a) > 0.94) active += 0.001;
      last = now;
    }
    EXPECT_GT(active / t.duration(), 0.97) << trial;
  }
}

TEST(Timing, IsWithinThreePercentOfTheMinTime) {
  Random random = Random::stream(21, "least time");
  for (int k = 0; k < 12; ++k) {
    TimingLimits limits = ur10_limits();
    limits.blend = std::array{0.005, 0.05, 0.2}[static_cast<std::size_t>(k % 3)];
    const JointPath path = random_path(random, static_cast<std::size_t>(3 + k % 8));
    const double min = min_time(path, limits);
    EXPECT_NEAR(time_path(path, limits).duration() / min, 1.0, 0.03) << k;
  }
}

TEST(Timing, CuttingCornersIsFasterThanStopping) {
  Random random(11);
  const JointPath path = random_path(random, 8);
  TimingLimits limits = ur10_limits();
  double last = 1e300;
  for (const double blend : {0.0, 0.005, 0.02, 0.1}) {
    limits.blend = blend;
    const double duration = time_path(path, limits).duration();
    EXPECT_LT(duration, last) << blend;
    last = duration;
  }
}

TEST(Timing, ReversalAndRepeatedPointsAreHandled) {
  JointPath path(5, Joints::Zero());
  path[1][1] = path[2][1] = 1.0;  // a point twice, then straight back
  for (const double blend : {0.0, 0.01}) {
    TimingLimits limits = ur10_limits();
    limits.blend = blend;
    const JointTrajectory t = time_path(path, limits);
    EXPECT_GT(t.duration(), 2 * (1.0 - blend) / 1.05);
    for (const Joints& q : t.q) EXPECT_TRUE(q.allFinite());
  }
}

TEST(Timing, PathWithoutLengthIsOneKnot) {
  const JointTrajectory t = time_path(JointPath(3, Joints::Ones()), ur10_limits());
  EXPECT_EQ(t.time.size(), 1u);
  EXPECT_EQ(t.duration(), 0.0);
}

/// Way points as of a straight tool motion: tiny phases between them must not slow the whole motion.
TEST(Timing, DenseWaypointsCostNoTime) {
  const RobotModel robot = read_robot("ur10");
  const Pose T_F_T(Eigen::Translation3d(0, 0, 0.264));
  for (std::uint64_t trial = 0; trial < 60; ++trial) {
    Random random = Random::stream(13, trial);
    JointPath path;
    const double phase = random.uniform(0.0, 3.0), curve = random.uniform(0.01, 0.2);
    const std::size_t count = 5 + random.index(60);
    for (std::size_t i = 0; i <= count; ++i) {
      const double s = static_cast<double>(i) / static_cast<double>(count);
      Joints q;
      q << 0.1 * s, -1.5 + 0.2 * s, 1.6 + curve * std::sin(2 * s + phase), -1.6 - 0.1 * s * s, -1.57, 0.3 * s;
      path.push_back(q);
    }
    TimingLimits limits = ur10_limits();
    limits.tool_speed = 0.10;
    limits.blend = 0.0003;
    const double whole = time_path(path, limits, robot, T_F_T).duration();
    limits.blend = 0.05;
    const double eased = time_path(path, limits, robot, T_F_T).duration();
    EXPECT_LT(whole, 1.5 * eased + 0.5) << trial;
    EXPECT_LT(whole, 12.0) << trial;
  }
}

TEST(Timing, RefusesWhatCannotBeTimed) {
  EXPECT_THROW((void)time_path({}, ur10_limits()), InvalidArgument);
  TimingLimits limits = ur10_limits();
  limits.velocity[2] = std::nan("");
  EXPECT_THROW((void)time_path(JointPath(2, Joints::Zero()), limits), InvalidArgument);
  JointPath path(2, Joints::Zero());
  path[1][3] = std::nan("");
  EXPECT_THROW((void)time_path(path, ur10_limits()), InvalidArgument);
}

TEST(Timing, ToolSpeedIsKept) {
  const RobotModel robot = read_robot("ur10");
  const Pose T_F_T(Eigen::Translation3d(0, 0, 0.264));
  TimingLimits limits = ur10_limits();
  limits.tool_speed = 0.05;
  for (int trial = 0; trial < 5; ++trial) {
    Random random = Random::stream(12, static_cast<std::uint64_t>(trial));
    const JointTrajectory t = time_path(random_path(random, 3), limits, robot, T_F_T);
    double fastest = 0.0;
    const auto tool = [&](double time) {
      return (forward(robot, hermite(t, time).q) * T_F_T).translation().eval();
    };
    for (double time = 0.01; time < t.duration(); time += 0.01)
      fastest = std::max(fastest, (tool(time) - tool(time - 0.002)).norm() / 0.002);
    EXPECT_LE(fastest, 0.0501) << trial;
    EXPECT_GE(fastest, 0.040) << trial;
  }
}

}  // namespace
}  // namespace stonestack::motion
