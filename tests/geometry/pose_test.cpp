#include "stonestack/geometry/pose.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::geometry {
namespace {

Pose random_pose(Random& random) {
  return make_pose(random.unit_vector(), random.rotation());
}

TEST(Pose, DifferenceIsTranslationAndAngle) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 2) / 3.0));
  const PoseDifference d = difference(make_pose({1, 0, 0}), make_pose({1, 3, 4}, turn));
  EXPECT_NEAR(d.translation, 5.0, 1e-15);
  EXPECT_NEAR(d.angle, 0.3, 1e-12);
}

TEST(Pose, DifferenceDoesNotDependOnTheFrame) {
  Random random = Random::stream(1, "pose");
  for (int i = 0; i < 100; ++i) {
    const Pose a = random_pose(random);
    const Pose b = random_pose(random);
    const Pose T = random_pose(random);
    EXPECT_NEAR(difference(a, b).angle, difference(T * a, T * b).angle, 1e-9);
    EXPECT_NEAR(difference(a, b).translation, difference(T * a, T * b).translation, 1e-12);
    EXPECT_NEAR(difference(a, a).angle, 0.0, 1e-7);
    EXPECT_LE(difference(a, b).angle, std::numbers::pi);
  }
}

TEST(Pose, InterpolationRunsAtConstantSpeed) {
  Random random = Random::stream(2, "pose");
  for (int i = 0; i < 100; ++i) {
    const Pose a = random_pose(random);
    const Pose b = random_pose(random);
    const double s = random.uniform();
    EXPECT_NEAR(difference(a, interpolate(a, b, s)).angle, s * difference(a, b).angle, 1e-6);
    EXPECT_TRUE(is_valid(interpolate(a, b, s)));
  }
  EXPECT_THROW((void)interpolate(Pose::Identity(), Pose::Identity(), 1.1), InvalidArgument);
}

TEST(Pose, OrthonormalRemovesDrift) {
  Pose pose = make_pose({1, 2, 3}, Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5));
  pose.linear() *= 1.0 + 1e-4;
  EXPECT_FALSE(is_valid(pose));
  EXPECT_TRUE(is_valid(orthonormal(pose)));
}

TEST(Pose, MirrorAndNanAreNotValid) {
  Pose pose = Pose::Identity();
  EXPECT_TRUE(is_valid(pose));
  pose.linear()(2, 2) = -1.0;
  EXPECT_FALSE(is_valid(pose));
  pose = Pose::Identity();
  pose.translation().x() = NAN;
  EXPECT_FALSE(is_valid(pose));
  EXPECT_THROW((void)make_pose({0, 0, 0}, Eigen::Quaterniond(0, 0, 0, 0)), InvalidArgument);
}

TEST(Pose, TextIsShortAndHasPositiveW) {
  EXPECT_EQ(to_text(make_pose({0.1, -0.0, 0.2}, Eigen::Quaterniond(-1, 0, 0, 0))),
            "{x: 0.1, y: 0, z: 0.2, qx: 0, qy: 0, qz: 0, qw: 1}");
}

}  // namespace
}  // namespace stonestack::geometry
