#include "geometry/depth_render.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "geometry/rough_stone.hpp"
#include "geometry/surface_tree.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::geometry {
namespace {

/// A camera `height` above the origin that looks down.
Pose looking_down(double height) {
  return make_pose({0, 0, height}, Eigen::Quaterniond(0, 1, 0, 0));
}

RayScene box_on_floor() {
  RayScene scene;
  EXPECT_EQ(scene.add(make_box({2, 2, 0.1}), make_pose({0, 0, -0.05})), 0);
  EXPECT_EQ(scene.add(make_box({0.2, 0.1, 0.1}), make_pose({0, 0, 0.05})), 1);
  scene.commit();
  return scene;
}

TEST(RayScene, HitsWhereTheBoxIs) {
  const RayScene scene = box_on_floor();
  const RayHit top = scene.cast({0.01, 0.02, 1.1}, {0, 0, -3});
  EXPECT_EQ(top.instance, 1);
  EXPECT_NEAR(top.distance, 1.0, 1e-12);
  EXPECT_LT((top.normal - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  const RayHit floor = scene.cast({0.5, 0, 1}, {0, 0, -1});
  EXPECT_EQ(floor.instance, 0);
  EXPECT_NEAR(floor.distance, 1.0, 1e-12);
  EXPECT_EQ(scene.cast({0, 0, 1}, {0, 0, 1}).instance, -1);
}

TEST(RayScene, RefusesMisuse) {
  RayScene scene;
  EXPECT_THROW((void)scene.cast({0, 0, 0}, {0, 0, 1}), InvalidArgument);
  EXPECT_THROW((void)scene.add(Mesh{}, Pose::Identity()), InvalidArgument);
  scene.commit();
  EXPECT_THROW((void)scene.add(make_box({1, 1, 1}), Pose::Identity()), InvalidArgument);
  EXPECT_THROW((void)scene.cast({0, 0, 0}, {0, 0, 0}), InvalidArgument);
  EXPECT_EQ(scene.cast({0, 0, 0}, {0, 0, 1}).instance, -1) << "an empty scene has no hits";
}

TEST(Render, DepthIsAlongTheOpticalAxis) {
  CameraIntrinsics camera;
  camera.width = 64;
  camera.height = 48;
  camera.fx = camera.fy = 47.5;
  camera.cx = 31.5;
  camera.cy = 23.5;
  const RenderedView view = render(box_on_floor(), camera, looking_down(1.0));
  const Cloud cloud_C = to_cloud(view.depth);
  int on_box = 0;
  for (std::size_t i = 0; i < cloud_C.points.size(); ++i) {
    ASSERT_GE(view.instance[i], 0);
    const Eigen::Vector3d p_W = looking_down(1.0) * cloud_C.points[i].cast<double>();
    if (view.normal_W[i].z() > 0.5F) {
      EXPECT_NEAR(p_W.z(), view.instance[i] == 1 ? 0.1 : 0.0, 1e-6);
    }
    on_box += view.instance[i];
  }
  EXPECT_NEAR(on_box, 0.2 * 0.1 * (47.5 / 0.9) * (47.5 / 0.9), 15);
}

TEST(Render, PointsLieOnTheStoneAndNormalsFaceTheCamera) {
  const Mesh stone = make_rough_stone(1);
  RayScene scene;
  Random random = Random::stream(1, "render");
  const Pose T_W_O = make_pose({0.05, -0.02, 0.1}, random.rotation());
  scene.add(stone, T_W_O);
  scene.commit();
  CameraIntrinsics camera;
  camera.width = 160;
  camera.height = 120;
  camera.fx = camera.fy = 120;
  camera.cx = 79.5;
  camera.cy = 59.5;
  camera.distortion = CameraIntrinsics::Distortion::kInverseBrownConrady;
  camera.k[0] = -0.05;
  const Pose T_W_C = looking_down(0.6);
  const RenderedView view = render(scene, camera, T_W_C);
  const SurfaceTree tree(stone);
  const Cloud cloud_C = to_cloud(view.depth);
  int hits = 0;
  for (std::size_t i = 0; i < cloud_C.points.size(); ++i) {
    if (view.instance[i] < 0) continue;
    ++hits;
    const Eigen::Vector3d p_W = T_W_C * cloud_C.points[i].cast<double>();
    EXPECT_LT(std::abs(tree.nearest(T_W_O.inverse() * p_W).distance), 2e-7);
    EXPECT_LT(view.normal_W[i].cast<double>().dot(p_W - T_W_C.translation()), 0.0);
  }
  EXPECT_GT(hits, 300);
}

TEST(RayScene, IsBlockedWhereARayHitsNearEnough) {
  RayScene scene;
  scene.add(make_rough_stone(4), make_pose({0.02, -0.01, 0.05}));
  scene.add(make_box({1, 1, 0.1}), make_pose({0, 0, -0.05}));
  scene.commit();
  Random random = Random::stream(4, "rays");
  int blocked = 0;
  for (int k = 0; k < 2000; ++k) {
    const Eigen::Vector3d from = 0.3 * random.unit_vector() + Eigen::Vector3d(0, 0, 0.31);
    const Eigen::Vector3d direction = random.unit_vector();
    const RayHit hit = scene.cast(from, direction);
    const double farthest = random.uniform(0.05, 0.6);
    if (hit.instance >= 0 && std::abs(hit.distance - farthest) < 1e-5) continue;
    EXPECT_EQ(scene.is_blocked(from, direction, farthest), hit.instance >= 0 && hit.distance < farthest);
    blocked += scene.is_blocked(from, direction, farthest) ? 1 : 0;
  }
  EXPECT_GT(blocked, 200);
  EXPECT_LT(blocked, 1800);
}

TEST(RayScene, ManyRaysFromAPointAreBlockedAsEachIs) {
  RayScene scene;
  scene.add(make_rough_stone(4), make_pose({0.02, -0.01, 0.05}));
  scene.commit();
  Random random = Random::stream(5, "rays");
  int all = 0;
  for (int k = 0; k < 200; ++k) {
    const Eigen::Vector3d from = Eigen::Vector3d(0.02, -0.01, 0.05) + 0.2 * random.unit_vector();
    std::vector<Eigen::Vector3d> directions(static_cast<std::size_t>(k % 20));  // whole packets and parts
    int blocked = 0;
    for (Eigen::Vector3d& direction : directions) {
      direction = (Eigen::Vector3d(0.02, -0.01, 0.05) - from + 0.1 * random.unit_vector()).normalized();
      blocked += scene.is_blocked(from, direction, 0.3) ? 1 : 0;
    }
    EXPECT_EQ(scene.count_blocked(from, directions, 0.3), blocked) << directions.size() << " rays";
    all += blocked;
  }
  EXPECT_GT(all, 200);
  EXPECT_LT(all, 1700);
}

TEST(Render, IsTheSameForOneAndForTwoThreads) {
  RayScene scene;
  scene.add(make_rough_stone(2), make_pose({0, 0, 0.05}));
  scene.add(make_box({1, 1, 0.1}), make_pose({0, 0, -0.05}));
  scene.commit();
  CameraIntrinsics camera;
  std::vector<float> depth[2];
  for (const std::size_t threads : {1, 2}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    depth[threads - 1] = render(scene, camera, looking_down(0.7)).depth.z;
  }
  EXPECT_EQ(depth[0], depth[1]);
}

}  // namespace
}  // namespace stonestack::geometry
