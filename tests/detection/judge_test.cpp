// Surface that fits a model and is none of it: flat where the model is round, or a patch of a plane.
#include <gtest/gtest.h>

#include "detection/features/models.hpp"
#include "detection/judge/bend.hpp"
#include "detection/judge/verify.hpp"
#include "detection/scene/preprocess.hpp"
#include "detection/test_scene.hpp"

namespace stonestack::detection {
namespace {

/// Unit normals of a cap of a sphere about z, up to `angle` [rad] from it.
std::vector<Eigen::Vector3d> cap(double angle) {
  std::vector<Eigen::Vector3d> normals;
  for (int k = 0; k < 200; ++k) {
    const double tilt = angle * k / 200.0, around = 2.4 * k;
    normals.emplace_back(std::sin(tilt) * std::cos(around), std::sin(tilt) * std::sin(around),
                         std::cos(tilt));
  }
  return normals;
}

TEST(BendTally, ComparesHowNormalsTurn) {
  const auto round = cap(0.6), flatter = cap(0.3);
  BendTally alike, half, flat, of_plane;
  for (std::size_t k = 0; k < round.size(); ++k) {
    alike.add(round[k], round[k], 1.0);
    half.add(round[k], flatter[k], 1.0);
    flat.add(round[k], Eigen::Vector3d::UnitZ(), 1.0);
    of_plane.add(Eigen::Vector3d::UnitZ(), round[k], 1.0);
  }
  for (BendTally* tally : {&alike, &half, &flat, &of_plane}) tally->end_view();
  EXPECT_NEAR(alike.agreement(), 1.0, 1e-9);
  EXPECT_NEAR(half.agreement(), 0.5, 0.05);
  EXPECT_NEAR(flat.agreement(), 0.0, 1e-9);
  EXPECT_GT(flat.variation(), 0.05);
  EXPECT_NEAR(of_plane.variation(), 0.0, 1e-9);
  EXPECT_EQ(of_plane.agreement(), 1.0) << "a plane has no bend that could differ";
}

TEST(BendTally, DirectionsOfOtherViewsAreNoBend) {
  BendTally tally;
  for (const double turn : {0.0, 1.5, 3.0}) {
    const Eigen::Vector3d n = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitX()) * Eigen::Vector3d::UnitZ();
    for (int k = 0; k < 10; ++k) tally.add(n, n, 1.0);
    tally.end_view();
  }
  EXPECT_NEAR(tally.variation(), 0.0, 1e-9);
}

/// Depth within `radius` px of the middle of the image; none elsewhere.
DepthImage only_within(DepthImage image, int radius) {
  const int width = image.camera.width, height = image.camera.height;
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      if (std::hypot(u - width / 2, v - height / 2) > radius)
        image.z[static_cast<std::size_t>(v * width + u)] = 0.0F;
  return image;
}

ScoreLosses losses(const Stone& stone, const Pose& T_C_O, const DepthImage& image) {
  VerifyOptions strict;
  strict.contour = true;
  return verify_pose(make_detection_model(stone), T_C_O, preprocess(image, {}, true, {}), strict).lost;
}

/// A stone of 5 to 7 cm under a camera that looks straight down at it.
class SmallStone : public ::testing::Test {
 protected:
  static Stone make() {
    Stone stone = test::make_test_stone(3);
    for (Mesh* mesh : {&stone.mesh, &stone.scan})
      for (Eigen::Vector3d& p : mesh->vertices) p *= 0.4;
    return stone;
  }
  Stone stone = make();
  Pose T_W_C = test::make_camera_pose(0.0, 0.0, 0.5);
  Pose T_W_O = test::on_table(stone, Eigen::Quaterniond::Identity(), 0.0, 0.0);
  Pose T_C_O = T_W_C.inverse() * T_W_O;
  DepthImage image = test::look_at({{&stone, T_W_O}}, T_W_C);
};

TEST_F(SmallStone, FlatSurfaceInItsPlaceIsNotBentAsItIs) {
  const ScoreLosses there = losses(stone, T_C_O, image);
  EXPECT_EQ(there.bend, 0.0);
  EXPECT_EQ(there.without_depth, 0.0);
  EXPECT_EQ(there.loose, 0.0);
  DepthImage flat = only_within(image, 20);
  const float z = flat.at(flat.camera.width / 2, flat.camera.height / 2) + 0.001F;
  for (float& depth : flat.z) depth = depth > 0 ? z : 0;
  const ScoreLosses patch = losses(stone, T_C_O, flat);
  EXPECT_GT(patch.bend, 0.1);
}

TEST_F(SmallStone, LittleOfItWithADepthIsLessEvidence) {
  EXPECT_GT(losses(stone, T_C_O, only_within(image, 12)).without_depth, 0.01);
}

TEST(FlatModel, APatchOfItsFaceWithoutAnOutlineFitsAnywhere) {
  Stone slab = test::make_test_stone(1);
  slab.mesh = slab.scan = make_box({0.12, 0.10, 0.04});
  const Pose T_W_C = test::make_camera_pose(0.0, 0.0, 0.5);
  const Pose T_W_O = test::on_table(slab, Eigen::Quaterniond::Identity(), 0.0, 0.0);
  const DepthImage image = test::look_at({{&slab, T_W_O}}, T_W_C);
  const Pose T_C_O = T_W_C.inverse() * T_W_O;
  EXPECT_EQ(losses(slab, T_C_O, image).loose, 0.0) << "its edges are seen";
  EXPECT_GT(losses(slab, T_C_O, only_within(image, 40)).loose, 0.2);
}

}  // namespace
}  // namespace stonestack::detection
