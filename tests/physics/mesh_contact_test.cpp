#include "physics/mesh_contact.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "physics/bodies.hpp"

namespace stonestack::physics {
namespace {

using test::at;

constexpr double kNear = 1e-5;  // m

std::vector<MeshTouch> touches(const Mesh& a, const Mesh& b, const Pose& T_W_A, const Pose& T_W_B) {
  return MeshPair().touches(make_contact_mesh(a), make_contact_mesh(b), T_W_A, T_W_B, kNear);
}

/// Corners of the smallest box around the touches, seen from above.
Eigen::AlignedBox2d patch(const std::vector<MeshTouch>& found) {
  Eigen::AlignedBox2d box;
  for (const MeshTouch& touch : found) box.extend(touch.p.head<2>().eval());
  return box;
}

TEST(MeshContact, FlatFacesTouchInTheCornersOfTheirCommonPatch) {
  const Mesh box = make_box({0.1, 0.1, 0.04});
  for (const double gap : {5e-6, 0.0, -1e-6, -1e-5, -1e-4})
    for (const double shift : {0.0, 0.02, -0.03}) {
      const auto found = touches(box, box, at(shift, 0.5 * shift, 0.04 + gap), at(0, 0, 0));
      ASSERT_GE(found.size(), 4u) << "gap " << gap << ", shift " << shift;
      for (const MeshTouch& touch : found) {
        EXPECT_GT(touch.n.z(), 0.99999) << "gap " << gap << ", shift " << shift;
        EXPECT_NEAR(touch.gap, gap, 1e-9);
        EXPECT_NEAR(touch.p.z(), 0.02, 1.1e-4);
      }
      EXPECT_NEAR(patch(found).sizes().x(), 0.1 - std::abs(shift), 2e-5);
      EXPECT_NEAR(patch(found).sizes().y(), 0.1 - 0.5 * std::abs(shift), 2e-5);
    }
}

TEST(MeshContact, TurnedFacesTouchWhereTheirSidesCross) {
  const Mesh box = make_box({0.1, 0.1, 0.04});
  const auto found = touches(box, box, at(0, 0, 0.04 - 1e-5, 0.5 * M_PI / 2), at(0, 0, 0));
  // Two squares turned by 45 deg share a regular octagon: each side crosses two of the other.
  ASSERT_EQ(found.size(), 8u);
  for (const MeshTouch& touch : found) {
    EXPECT_NEAR(touch.p.head<2>().norm(), 0.05 / std::cos(M_PI / 8), 1e-6);
    EXPECT_NEAR(touch.gap, -1e-5, 1e-9);
    EXPECT_GT(touch.n.z(), 0.99999);
  }
}

/// A roof whose ridge, of 0.1 m, lies along x at z = 0; it is as steep as 45 deg.
Mesh roof() {
  const Eigen::Matrix3d R = Eigen::AngleAxisd(M_PI / 4, Eigen::Vector3d::UnitX()).toRotationMatrix();
  Pose T = Pose::Identity();
  T.linear() = R;
  T.translation() = Eigen::Vector3d(0, 0, -0.05 * std::sqrt(0.5));
  return transformed(make_box({0.1, 0.05, 0.05}), T);
}

TEST(MeshContact, CrossingRidgesTouchOnceAcrossBoth) {
  const Eigen::Matrix3d over = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  for (const double gap : {0.0, -1e-5, -3e-4, -9e-4}) {
    Pose T_W_A = at(0.003, 0.004, gap, 1.0);
    T_W_A.linear() = T_W_A.linear() * over;
    const auto found = touches(roof(), roof(), T_W_A, at(0, 0, 0));
    ASSERT_EQ(found.size(), 1u) << gap;
    EXPECT_NEAR(found[0].gap, gap, 1e-9);
    EXPECT_GT(found[0].n.z(), 0.999999);
    EXPECT_NEAR(found[0].p.y(), 0.0, 1e-9);
  }
}

TEST(MeshContact, ACornerBelowAFaceNearItsRimIsNotFarBelowTheSide) {
  // The corner of a cube on its tip is 0.1 mm below the top of a box and 1 mm from its side.
  const Eigen::Quaterniond on_tip =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(0, 0, 1));
  const double half = 0.03 * std::sqrt(3.0);
  const auto found = touches(make_box({0.06, 0.06, 0.06}), make_box({0.1, 0.1, 0.04}),
                             make_pose({0.049, 0, 0.02 + half - 1e-4}, on_tip), at(0, 0, 0));
  ASSERT_FALSE(found.empty());
  for (const MeshTouch& touch : found) {
    EXPECT_NEAR(touch.gap, -1e-4, 1e-6);
    EXPECT_GT(touch.n.z(), 0.99999);
  }
}

TEST(MeshContact, AMovingBodyIsFoundAsOneThatAppears) {
  const ContactMesh a = make_contact_mesh(test::rough_slab({0.08, 0.06, 0.04}, 3));
  const ContactMesh b = make_contact_mesh(test::rough_slab({0.10, 0.10, 0.04}, 4));
  MeshPair kept;
  std::size_t total = 0;
  for (int k = 0; k < 60; ++k) {
    const Pose T_W_A =
        make_pose({0.01 + 1e-4 * k, 0, 0.0395 - 2e-5 * k},
                  Eigen::Quaterniond(Eigen::AngleAxisd(5e-4 * k, Eigen::Vector3d(0.6, 0.0, 0.8))));
    const auto followed = kept.touches(a, b, T_W_A, at(0, 0, 0), kNear);
    const auto fresh = MeshPair().touches(a, b, T_W_A, at(0, 0, 0), kNear);
    total += fresh.size();
    for (const MeshTouch& touch : fresh)
      EXPECT_TRUE(std::any_of(followed.begin(), followed.end(), [&](const MeshTouch& other) {
        return other.features == touch.features && other.gap == touch.gap;
      })) << k;
  }
  EXPECT_GT(total, 30u);
}

}  // namespace
}  // namespace stonestack::physics
