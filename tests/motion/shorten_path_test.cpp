#include "motion/path/shorten_path.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "motion/transit.hpp"

namespace stonestack::motion {
namespace {

Joints at(double x, double y) {
  Joints q = Joints::Zero();
  q[0] = x;
  q[1] = y;
  return q;
}

/// Around the end of a wall: the shortest path touches it, and straight cuts come near it only slowly.
TEST(Shortcut, PullsAWaypointTowardsAnObstacle) {
  const MotionTest over_the_wall = [](const Joints& a, const Joints& b) {
    if ((a[0] < 0.0) == (b[0] < 0.0)) return true;
    return a[1] + (b[1] - a[1]) * a[0] / (a[0] - b[0]) >= 1.0;
  };
  const JointPath path{at(-1, 0), at(0, 2), at(1, 0)};
  double sum = 0.0;
  for (std::uint64_t k = 0; k < 50; ++k) {
    Random random = Random::stream(3, k);
    const JointPath shorter = shortcut(path, over_the_wall, 20, random);
    for (std::size_t i = 1; i < shorter.size(); ++i) ASSERT_TRUE(over_the_wall(shorter[i - 1], shorter[i]));
    sum += length(shorter);
  }
  EXPECT_LT(sum / 50 / std::sqrt(8.0), 1.17);
}

}  // namespace
}  // namespace stonestack::motion
