#include "motion/collision/overlap.hpp"

#include <gtest/gtest.h>

namespace stonestack::motion {
namespace {

SceneObject cube_at(const Eigen::Vector3d& p_W, double turn = 0.0) {
  return {"cube",
          {make_box(Eigen::Vector3d::Ones())},
          make_pose(p_W, Eigen::Quaterniond(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ())))};
}

TEST(Overlap, CubesOverlapWhereTheyShareSpace) {
  EXPECT_TRUE(objects_overlap(cube_at({0, 0, 0}), cube_at({0.99, 0.5, 0})));
  EXPECT_FALSE(objects_overlap(cube_at({0, 0, 0}), cube_at({1.01, 0.5, 0})));
  EXPECT_TRUE(objects_overlap(cube_at({0, 0, 0}), cube_at({0.1, 0, 0}))) << "one within the other";
  // Turned by 45 deg a cube reaches sqrt(2)/2 along x.
  EXPECT_TRUE(objects_overlap(cube_at({0, 0, 0}), cube_at({1.19, 0, 0}, M_PI / 4)));
  EXPECT_FALSE(objects_overlap(cube_at({0, 0, 0}), cube_at({1.22, 0, 0}, M_PI / 4)));
}

TEST(Overlap, AnyPieceOfAnObjectCounts) {
  SceneObject two = cube_at({0, 0, 0});
  two.pieces.push_back(transformed(two.pieces[0], make_pose({0, 3, 0})));
  EXPECT_TRUE(objects_overlap(two, cube_at({0.5, 3.0, 0})));
  EXPECT_FALSE(objects_overlap(two, cube_at({0.0, 1.5, 0}))) << "between the two";
  EXPECT_FALSE(objects_overlap(two, {"nothing", {}, Pose::Identity()}));
}

}  // namespace
}  // namespace stonestack::motion
