#include "benchmarks/pose_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/constants.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::bench {
namespace {

Pose turned(double angle, const Eigen::Vector3d& axis) {
  return make_pose(Eigen::Vector3d::Zero(), Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis)));
}

const Eigen::Vector3d kX = Eigen::Vector3d::UnitX(), kZ = Eigen::Vector3d::UnitZ();
const Pose kSeen = make_pose(
    {0.02, -0.01, 0.6}, Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())));

/// A box of 12 x 8 x 5 cm; `discrete` leave it as it is.
ScoredObject box(const std::vector<Pose>& discrete) {
  return make_scored_object(make_box({0.12, 0.08, 0.05}), symmetries(discrete, {}), std::nullopt);
}

TEST(PoseError, DiameterIsTheMaxDistanceOfTwoPoints) {
  EXPECT_NEAR(box({}).diameter, std::sqrt(0.12 * 0.12 + 0.08 * 0.08 + 0.05 * 0.05), 1e-12);
  EXPECT_EQ(make_scored_object(make_box({0.1, 0.1, 0.1}), std::nullopt, 0.25).diameter, 0.25);
}

TEST(PoseError, AMovedObjectIsOffByWhatItWasMoved) {
  const ScoredObject object = box({});
  Pose moved = kSeen;
  moved.pretranslate(Eigen::Vector3d(0.003, 0.0, 0.004));
  EXPECT_NEAR(mssd(object, moved, kSeen), 0.005, 1e-12);
  EXPECT_NEAR(symmetric_difference(object, moved, kSeen).translation, 0.005, 1e-12);
  EXPECT_LE(add_s(object, moved, kSeen), 0.005 + 1e-12);
}

TEST(PoseError, AHalfTurnMattersToNothingThatItLeavesAsItIs) {
  const Pose half = turned(kPi, kZ);
  const CameraIntrinsics camera;
  const double diagonal = std::hypot(0.12, 0.08);  // the corners change places
  EXPECT_NEAR(mssd(box({}), kSeen * half, kSeen), diagonal, 1e-9);
  EXPECT_GT(mspd(box({}), kSeen * half, kSeen, camera), 50.0);
  EXPECT_NEAR(symmetric_difference(box({}), kSeen * half, kSeen).angle, kPi, 1e-6);
  const ScoredObject symmetric = box({half});
  EXPECT_NEAR(mssd(symmetric, kSeen * half, kSeen), 0.0, 1e-9);
  EXPECT_NEAR(mspd(symmetric, kSeen * half, kSeen, camera), 0.0, 1e-6);
  EXPECT_NEAR(symmetric_difference(symmetric, kSeen * half, kSeen).angle, 0.0, 1e-6);
  EXPECT_NEAR(mssd(symmetric, kSeen * turned(kPi, kX), kSeen), std::hypot(0.08, 0.05), 1e-9)
      << "another half turn is still wrong";
}

TEST(PoseError, AddSNeedsNoSymmetries) {
  const ScoredObject object = make_scored_object(make_box({0.12, 0.08, 0.05}), std::nullopt, std::nullopt);
  EXPECT_NEAR(add_s(object, kSeen * turned(kPi, kZ), kSeen), 0.0, 1e-9);
  EXPECT_GT(add_s(object, kSeen * turned(kPi / 4, kZ), kSeen), 0.01);
  EXPECT_THROW((void)mssd(object, kSeen, kSeen), InvalidArgument);
  EXPECT_THROW((void)symmetric_difference(object, kSeen, kSeen), InvalidArgument);
}

TEST(PoseError, AnyTurnAboutAnAxisBesideTheOriginIsASymmetry) {
  const Eigen::Vector3d p(0.03, -0.02, 0.0);
  const std::vector<Pose> all = symmetries({}, {{kX, p}});
  ASSERT_EQ(all.size(), 315u);  // as get_symmetry_transformations of the BOP toolkit, and the identity
  EXPECT_TRUE(all.front().isApprox(Pose::Identity()));
  for (const Pose& symmetry : all) EXPECT_LT((symmetry * p - p).norm(), 1e-12) << "the axis moves";
  ScoredObject object = make_scored_object(make_box({0.12, 0.05, 0.05}), all, std::nullopt);
  Random random = Random::stream(1, "turns");
  for (int k = 0; k < 50; ++k) {
    const Pose turn =
        Eigen::Translation3d(p) * turned(random.uniform(-kPi, kPi), kX) * Eigen::Translation3d(-p);
    // Half a step of 2 pi / 315 at the farthest corner from the axis.
    EXPECT_LT(mssd(object, kSeen * turn, kSeen), kPi / 315 * 0.09) << k;
    EXPECT_LT(symmetric_difference(object, kSeen * turn, kSeen).angle, kPi / 315 + 1e-6) << k;
  }
  EXPECT_GT(mssd(object, kSeen * turned(kPi / 2, kZ), kSeen), 0.02);
}

TEST(PoseError, DiscreteAndContinuousSymmetriesCombine) {
  // A cylinder along z that may also stand on its head.
  const std::vector<Pose> all = symmetries({turned(kPi, kX)}, {{kZ, Eigen::Vector3d::Zero()}});
  EXPECT_EQ(all.size(), 2u * 315u);
  const ScoredObject object = make_scored_object(make_box({0.05, 0.05, 0.12}), all, std::nullopt);
  const Pose turn = turned(1.1, kZ) * turned(kPi, kX) * turned(-0.4, kZ);
  EXPECT_LT(symmetric_difference(object, kSeen * turn, kSeen).angle, kPi / 315 + 1e-6);
}

TEST(PoseError, NothingIsProjectedBehindTheCamera) {
  EXPECT_TRUE(std::isinf(mspd(box({}), make_pose(Eigen::Vector3d(0, 0, -0.5)), kSeen, {})));
}

}  // namespace
}  // namespace stonestack::bench
