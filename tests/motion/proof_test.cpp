#include "motion/collision/proof.hpp"

#include <gtest/gtest.h>

#include "stonestack/core/random.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

Joints draw(Random& random, double max) {
  Joints q;
  for (auto& angle : q) angle = random.uniform(-max, max);
  return q;
}

TEST(LargestShift, NoPointOfTheCapsuleGetsFurther) {
  const RobotModel robot = read_robot("ur10");
  Random random = Random::stream(14, "shifts");
  double tightest = 0.0;
  for (int k = 0; k < 2000; ++k) {
    const Joints q = draw(random, 3.0), turn = draw(random, 0.3).cwiseAbs();
    const auto pose = link_poses(robot, q);
    const std::size_t link = 1 + random.index(6), base = random.index(link);
    const Segment local{{0.1, 0.0, 0.2}, {-0.3, 0.1, 0.0}};
    const double reach = 0.05;
    const Segment axis{pose[link] * local.a, pose[link] * local.b};
    const double bound = max_shift(pose, turn, axis, reach, link, base);
    Joints moved = q;
    for (Eigen::Index j = 0; j < 6; ++j) moved[j] += turn[j] * (random.uniform() < 0.5 ? -1.0 : 1.0);
    const auto after = link_poses(robot, moved);
    for (const auto& end : {local.a, local.b}) {
      const Eigen::Vector3d p = end + reach * random.unit_vector();
      const double shift =
          (after[base].inverse() * after[link] * p - pose[base].inverse() * pose[link] * p).norm();
      ASSERT_LE(shift, bound) << "case " << k;
      tightest = std::max(tightest, shift / bound);
    }
  }
  EXPECT_GT(tightest, 0.9);
}

/// One joint: as far as the capsule's furthest point is from the axis, whatever lies between in the chain.
TEST(LargestShift, IsTheArcOfOneJoint) {
  const RobotModel robot = read_robot("ur10");
  const Joints q = (Joints() << 0.3, -1.2, 2.2, 0.4, 1.0, 0.5).finished();  // folded: near the base's axis
  const auto pose = link_poses(robot, q);
  const Eigen::Vector3d p = pose[6].translation();
  const Joints turn = 0.1 * Joints::Unit(0);
  EXPECT_NEAR(max_shift(pose, turn, {p, p}, 0.0, 6), 0.1 * p.head<2>().norm(), 1e-12);
}

}  // namespace
}  // namespace stonestack::motion
