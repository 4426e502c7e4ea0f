#include "stonestack/geometry/mesh.hpp"

#include <gtest/gtest.h>

#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::geometry {
namespace {

TEST(MassProperties, OfABoxAreExact) {
  const MassProperties box = mass_properties(make_box({0.1, 0.2, 0.3}), 2600.0);
  const double mass = 2600.0 * 0.006;
  EXPECT_NEAR(box.mass, mass, 1e-12);
  EXPECT_LT(box.p_O_M.norm(), 1e-15);
  const Eigen::Vector3d moments = mass / 12 * Eigen::Vector3d(0.04 + 0.09, 0.01 + 0.09, 0.01 + 0.04);
  EXPECT_LT((box.I_M - Eigen::Matrix3d(moments.asDiagonal())).norm(), 1e-14);
  EXPECT_EQ(check(box), "");
}

TEST(MassProperties, OfATetrahedronAreExact) {
  Mesh corner;
  corner.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  corner.faces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const MassProperties body = mass_properties(corner, 6.0);
  EXPECT_NEAR(body.mass, 1.0, 1e-14);
  EXPECT_LT((body.p_O_M - Eigen::Vector3d::Constant(0.25)).norm(), 1e-14);
  // About the origin, integral of x^2 is 6/60 and of xy 6/120; the axes are moved by 1/4.
  EXPECT_NEAR(body.I_M(0, 0), 2 * (0.1 - 0.0625), 1e-14);
  EXPECT_NEAR(body.I_M(0, 1), -(0.05 - 0.0625), 1e-14);
}

TEST(MassProperties, FollowTheBody) {
  Random random = Random::stream(7, "mass properties");
  const MassProperties at_origin = mass_properties(make_box({0.1, 0.15, 0.07}), 2500.0);
  for (int i = 0; i < 50; ++i) {
    const Pose T_W_O = make_pose(10.0 * random.unit_vector(), random.rotation());
    const MassProperties moved = mass_properties(transformed(make_box({0.1, 0.15, 0.07}), T_W_O), 2500.0);
    EXPECT_NEAR(moved.mass, at_origin.mass, 1e-10);
    EXPECT_LT((moved.p_O_M - T_W_O.translation()).norm(), 1e-12);
    const Eigen::Matrix3d turned = T_W_O.linear() * at_origin.I_M * T_W_O.linear().transpose();
    EXPECT_LT((moved.I_M - turned).norm(), 1e-10);
  }
}

TEST(MassProperties, OfASphereConverge) {
  const MassProperties ball = mass_properties(make_sphere(0.1, 5), 1000.0);
  EXPECT_NEAR(ball.mass, 1000.0 * 4.18879e-3, 0.005);
  EXPECT_NEAR(ball.I_M(1, 1) / (0.4 * ball.mass * 0.01), 1.0, 2e-3);
}

TEST(MassProperties, RefuseAnInsideOutMesh) {
  Mesh box = make_box({1, 1, 1});
  for (Eigen::Vector3i& face : box.faces) std::swap(face[0], face[1]);
  EXPECT_THROW((void)mass_properties(box, 1000.0), InvalidArgument);
  EXPECT_THROW((void)mass_properties(Mesh{}, 1000.0), InvalidArgument);
  EXPECT_THROW((void)mass_properties(make_box({1, 1, 1}), 0.0), InvalidArgument);
}

TEST(MassProperties, CheckFindsWhatIsImpossible) {
  MassProperties body = mass_properties(make_box({1, 1, 1}), 1.0);
  body.I_M.diagonal() = Eigen::Vector3d(0.1, 0.1, 0.3);
  EXPECT_NE(check(body).find("triangle"), std::string::npos);
  body.I_M.diagonal() = Eigen::Vector3d(-0.1, 0.1, 0.1);
  EXPECT_NE(check(body).find("positive definite"), std::string::npos);
  body.mass = -1;
  EXPECT_NE(check(body).find("mass"), std::string::npos);
  body.mass = NAN;
  EXPECT_NE(check(body).find("finite"), std::string::npos);
}

}  // namespace
}  // namespace stonestack::geometry
