#include "detection/scene/supports.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/constants.hpp"
#include "detection/test_scene.hpp"

namespace stonestack::detection {
namespace {

constexpr double kBenchHeight = 0.8;  // m
constexpr double kLongest = 0.18;     // m, of the models

/// A stone on a bench that stands on the floor (z = 0, the largest plane) before a wall of half a metre.
class StoneOnABench : public ::testing::Test {
 protected:
  static Pose camera() {
    const Eigen::Quaterniond down(Eigen::AngleAxisd(M_PI - 0.45, Eigen::Vector3d::UnitX()));
    return make_pose(Eigen::Vector3d(0, 0, kBenchHeight) + down * Eigen::Vector3d(0, 0, -0.75), down);
  }

  static DepthImage see(const Mesh& stone_O, const Pose& T_W_O, std::uint64_t seed) {
    RayScene world;
    world.add(make_box({4.0, 4.0, 0.02}), make_pose(Eigen::Vector3d(0, 0, -0.01)));
    world.add(make_box({0.42, 0.34, 0.03}), make_pose(Eigen::Vector3d(0, 0, kBenchHeight - 0.015)));
    world.add(make_box({0.5, 0.03, 0.5}), make_pose(Eigen::Vector3d(0.45, 0.1, kBenchHeight - 0.3)));
    world.add(stone_O, T_W_O);
    world.commit();
    return test::with_noise(render(world, {}, camera()).depth, 0.0008, seed);
  }

  Stone stone = test::make_test_stone(3);
  Pose T_W_O = make_pose(Eigen::Vector3d(0, 0, kBenchHeight)) *
               test::on_table(stone, Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ())),
                              0.03, -0.02);
  DepthImage image = see(stone.scan, T_W_O, 1);
  DetectionScene scene = without_large_planes(preprocess(image, {}, true, {}), kLongest, 1);
  Pose T_C_W = camera().inverse();
};

TEST_F(StoneOnABench, TheBenchCarriesAndIsNoObject) {
  ASSERT_TRUE(scene.table_C.has_value());
  EXPECT_NEAR(scene.table_C->distance(T_C_W * Eigen::Vector3d::Zero()), 0.0, 0.004) << "the floor is larger";
  ASSERT_EQ(scene.supports.size(), 1U);
  const PlaneOutline& bench = scene.supports[0];
  EXPECT_NEAR(bench.plane().distance(T_C_W * Eigen::Vector3d(0, 0, kBenchHeight)), 0.0, 0.001);
  EXPECT_LT(std::acos(bench.plane().normal.dot(T_C_W.linear().col(2))), 0.3 * kDegree);
  EXPECT_NEAR(bench.length(), std::hypot(0.42, 0.34), 0.03);
  EXPECT_GT(bench.margin(T_C_W * Eigen::Vector3d(0.19, 0.15, kBenchHeight)), 0.0);
  EXPECT_LT(bench.margin(T_C_W * Eigen::Vector3d(0.25, 0.0, kBenchHeight)), -0.03);
  const Eigen::Vector3d middle = T_W_O * bounds(stone.mesh).center();
  int of_bench = 0, of_stone = 0;
  for (const auto& p : scene.surface.points) {
    const Eigen::Vector3d p_W = camera() * p.cast<double>();
    const bool beside = (p_W - middle).head<2>().norm() > 0.12;
    of_bench += std::abs(p_W.z() - kBenchHeight) < 0.004 && beside ? 1 : 0;
    of_stone += p_W.z() > kBenchHeight + 0.01 && !beside ? 1 : 0;
  }
  EXPECT_LT(of_bench, 300) << "of 15,000: rims at most";
  EXPECT_GT(of_stone, 400);
}

TEST_F(StoneOnABench, NothingReachesBelowTheBenchWhereItIs) {
  ASSERT_EQ(scene.supports.size(), 1U);
  const auto carried = [&](double x, double z) {
    return planes_below(scene, T_C_W * Eigen::Vector3d(x, 0, z));
  };
  EXPECT_EQ(carried(0.0, kBenchHeight + 0.05).size(), 2U);
  EXPECT_EQ(carried(0.35, kBenchHeight + 0.05).size(), 1U) << "beside it";
  EXPECT_EQ(carried(0.0, kBenchHeight - 0.10).size(), 1U) << "under it";
  EXPECT_TRUE(planes_below(DetectionScene{}, Eigen::Vector3d::Zero()).empty());
}

TEST_F(StoneOnABench, IsFoundHoweverHighAboveTheFloor) {
  const DetectionModels models(std::span(&stone, 1));
  const auto found = detect_stones(image, models);
  ASSERT_EQ(found.detections.size(), 1U) << found.note;
  const PoseDifference off = difference(found.detections[0].T_C_O, T_C_W * T_W_O);
  EXPECT_LT(off.translation, 0.004);
  EXPECT_LT(off.angle, 4 * kDegree);
}

TEST(LargePlanes, StonesOnATableKeepTheirFaces) {
  Stone slab;
  slab.mesh = slab.scan = make_box({0.15, 0.10, 0.04});
  std::vector<test::StandingStone> row;
  for (int i = 0; i < 3; ++i)
    row.push_back({&slab, make_pose({0.19 * (i - 1), 0.0, 0.02}, Eigen::Quaterniond(Eigen::AngleAxisd(
                                                                     0.2 * i, Eigen::Vector3d::UnitZ())))});
  const DepthImage image = test::with_noise(test::look_at(row, test::make_camera_pose(0.4, 0.2)), 0.0006, 1);
  const DetectionScene before = preprocess(image, {}, true, {});
  const DetectionScene after = without_large_planes(before, 0.19, 1);
  EXPECT_TRUE(after.supports.empty());
  EXPECT_EQ(after.surface.points.size(), before.surface.points.size());
}

TEST(Noise, GrowsWithDepthBehindTheTableAndFallsWellBeforeIt) {
  DetectionScene scene;
  scene.noise = 0.004;
  EXPECT_EQ(noise_at(scene, 1.0), 0.004) << "nothing showed at which depth";
  scene.noise_depth = 2.0;
  EXPECT_EQ(noise_at(scene, 2.0), 0.004);
  EXPECT_EQ(noise_at(scene, 1.6), 0.004) << "what stands on the table is seen as it is";
  EXPECT_EQ(noise_at(scene, 2.3), 0.004);
  EXPECT_NEAR(noise_at(scene, 4.6), 0.016, 1e-12);
  EXPECT_NEAR(noise_at(scene, 0.7), 0.001, 1e-12);
}

}  // namespace
}  // namespace stonestack::detection
