#include "stonestack/kinematics/joints.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "stonestack/core/error.hpp"

namespace stonestack {
namespace {

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

}  // namespace
}  // namespace stonestack
