#include <gtest/gtest.h>

#include "modelling/camera_error.hpp"
#include "seen_things.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::modelling {
namespace {

using namespace test;

/// A small rigid motion: up to 2 mm and 0.3 deg an axis.
Pose disturbed(const Pose& pose, Random& random) {
  const auto draw = [&](double size) { return size * (2.0 * random.uniform() - 1.0); };
  const Eigen::Vector3d w(draw(0.005), draw(0.005), draw(0.005));
  Pose off = make_pose({draw(0.002), draw(0.002), draw(0.002)});
  off.rotate(Eigen::AngleAxisd(w.norm(), w.normalized()));
  return off * pose;
}

std::vector<DepthView> with_wrong_poses(std::vector<DepthView> views) {
  Random random(5);
  for (DepthView& view : views) view.T_W_C = disturbed(view.T_W_C, random);
  return views;
}

TEST(AlignScene, ViewsWithWrongPosesAreBroughtToAgree) {
  const std::vector<Pose> cameras = cameras_around(4);
  const auto exact = views_of({lying_stone(3, 0.0, 0.0), lying_stone(4, 0.15, 0.1, 1.0)}, cameras);
  const AlignedScene scene = align_scene(with_wrong_poses(exact));
  EXPECT_GT(scene.apart_before, 0.0010);
  EXPECT_LT(scene.apart_after, 0.0008);
  EXPECT_LT(scene.apart_after, 0.6 * scene.apart_before);
  EXPECT_EQ(scene.segmentation.objects.size(), 2U);
  // Against each other: the pose of camera k as camera 0 sees it.
  for (std::size_t k = 1; k < cameras.size(); ++k) {
    const Pose is = cameras[0].inverse() * cameras[k];
    const Pose found = scene.views[0].T_W_C.inverse() * scene.views[k].T_W_C;
    const PoseDifference off = difference(is, found);
    EXPECT_LT(off.translation, 0.0015) << k;
    EXPECT_LT(off.angle, 0.0025) << k;
  }
}

TEST(AlignScene, TheTableIsAtZero) {
  auto views = views_of({lying_stone(3, 0.0, 0.0)}, cameras_around(3));
  for (DepthView& view : views) view.T_W_C = Eigen::Translation3d(0, 0, 0.01) * view.T_W_C;
  const AlignedScene scene = align_scene(views);
  const Pose& T_W_C = scene.views.front().T_W_C;
  ASSERT_TRUE(scene.segmentation.table_C.has_value());
  const Plane& table_C = *scene.segmentation.table_C;
  const Eigen::Vector3d n_W = T_W_C.linear() * table_C.normal;
  EXPECT_NEAR(n_W.z(), 1.0, 1e-4);
  EXPECT_NEAR(table_C.offset + n_W.dot(T_W_C.translation()), 0.0, 0.001);
}

TEST(AlignScene, ExactPosesAreKept) {
  const auto views = with_wrong_poses(views_of({lying_stone(3, 0.0, 0.0)}, cameras_around(2)));
  ModellingOptions options;
  options.refine_poses = false;
  const AlignedScene scene = align_scene(views, options);
  EXPECT_TRUE(scene.views[1].T_W_C.isApprox(views[1].T_W_C));
}

TEST(AlignScene, DepthsOutOfRangeAreNotAligned) {
  ModellingOptions options;
  const auto views = with_wrong_poses(views_of({lying_stone(3, 0.0, 0.0)}, cameras_around(2)));
  EXPECT_GT(align_scene(views, options).apart_before, 0.0);
  options.segment.farthest = 0.3;  // cameras stand 0.55 m from the stone
  EXPECT_EQ(align_scene(views, options).apart_before, 0.0);
  EXPECT_TRUE(measure_camera_error(views, options.segment).offset.empty());
}

TEST(AlignScene, AnImageThatLacksDepthsIsRefused) {
  auto views = views_of({lying_stone(3, 0.0, 0.0)}, cameras_around(3));
  views[1].image.z.resize(views[1].image.z.size() / 2);
  EXPECT_THROW((void)align_scene(views), InvalidArgument);
}

TEST(AlignScene, NoViewIsRefused) {
  EXPECT_THROW((void)align_scene({}), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::modelling
