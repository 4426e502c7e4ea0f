#include "stonestack/geometry/cloud.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

namespace stonestack::geometry {
namespace {

TEST(Cloud, TransformTurnsPointsAndNormals) {
  Cloud cloud;
  cloud.points = {{1, 0, 0}};
  cloud.normals = {{1, 0, 0}};
  const Eigen::Quaterniond quarter_turn(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()));
  const Cloud moved = transformed(cloud, make_pose({0, 0, 5}, quarter_turn));
  EXPECT_LT((moved.points[0] - Eigen::Vector3f(0, 1, 5)).norm(), 1e-6F);
  EXPECT_LT((moved.normals[0] - Eigen::Vector3f(0, 1, 0)).norm(), 1e-6F);
}

TEST(Cloud, WithoutGapsKeepsOrderAndNormals) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  Cloud cloud;
  cloud.points = {{1, 0, 0}, {kNan, 0, 0}, {3, 0, 0}, {4, 0, kNan}};
  cloud.normals = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}};
  cloud.width = cloud.height = 2;
  const Cloud dense = without_gaps(cloud);
  ASSERT_EQ(dense.points.size(), 2U);
  EXPECT_EQ(dense.points[1], Eigen::Vector3f(3, 0, 0));
  EXPECT_EQ(dense.normals[1], Eigen::Vector3f(1, 0, 0));
  EXPECT_EQ(dense.width, 2);
  EXPECT_EQ(dense.height, 1);
}

}  // namespace
}  // namespace stonestack::geometry
