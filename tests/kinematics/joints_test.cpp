#include "stonestack/kinematics/robot_model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "stonestack/core/error.hpp"

namespace stonestack::kinematics {
namespace {

using ::testing::HasSubstr;

/// Knots of the cubic q = 1 + 2 t - t^2 + 0.5 t^3 in every joint: Hermite pieces must give it back exactly.
JointTrajectory cubic() {
  JointTrajectory trajectory;
  for (const double t : {0.0, 0.3, 1.1, 2.0}) {
    trajectory.time.push_back(t);
    trajectory.q.push_back(Joints::Constant(1 + 2 * t - t * t + 0.5 * t * t * t));
    trajectory.qd.push_back(Joints::Constant(2 - 2 * t + 1.5 * t * t));
  }
  return trajectory;
}

TEST(Joints, SampleGivesBackACubic) {
  const auto trajectory = cubic();
  for (double t = 0.0; t <= 2.0; t += 0.01) {
    const auto state = sample(trajectory, t);
    EXPECT_NEAR(state.q[3], 1 + 2 * t - t * t + 0.5 * t * t * t, 1e-12);
    EXPECT_NEAR(state.qd[3], 2 - 2 * t + 1.5 * t * t, 1e-12);
  }
}

TEST(Joints, SampleIsClampedToTheEnds) {
  const auto trajectory = cubic();
  EXPECT_EQ(sample(trajectory, -1.0).q, trajectory.q.front());
  EXPECT_EQ(sample(trajectory, 9.0).q, trajectory.q.back());
  EXPECT_DOUBLE_EQ(trajectory.duration(), 2.0);
}

TEST(Joints, SampleRefusesWhatIsNoTrajectory) {
  EXPECT_THROW((void)sample({}, 0.0), InvalidArgument);
  auto trajectory = cubic();
  trajectory.qd.pop_back();
  EXPECT_THROW((void)sample(trajectory, 0.0), InvalidArgument);
}

TEST(Joints, MalformedEntriesAreNamed) {
  EXPECT_EQ(malformed(cubic()), "");
  EXPECT_THAT(malformed({}), HasSubstr("got 0, 0, 0"));
  const auto fault = [](const auto& spoil) {
    auto trajectory = cubic();
    spoil(trajectory);
    return malformed(trajectory);
  };
  EXPECT_THAT(fault([](auto& t) { t.q.pop_back(); }), HasSubstr("as many times as positions and velocities"));
  EXPECT_THAT(fault([](auto& t) { t.q[1][3] = std::nan(""); }),
              HasSubstr("knot 1 of the trajectory is not finite"));
  EXPECT_THAT(fault([](auto& t) { t.time[0] = 0.1; }), HasSubstr("knot 0 is at 0.1 s"));
  EXPECT_THAT(fault([](auto& t) { t.time[1] = t.time[0]; }), HasSubstr("knot 1 is at 0 s"));
}

}  // namespace
}  // namespace stonestack::kinematics
