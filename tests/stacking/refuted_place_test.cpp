#include "stacking/refuted_place.hpp"

#include <gtest/gtest.h>

#include "geometry/depth_render.hpp"
#include "unknown_pile.hpp"

namespace stonestack::stacking {
namespace {

const Mesh& stone() {
  static const Mesh mesh = make_box({0.08, 0.07, 0.05});
  return mesh;
}
const Pose kPlace = make_pose({0.0, 0.0, 0.025});

/// A view of boxes on a table, from obliquely above.
CameraView view_of(const std::vector<std::pair<Mesh, Pose>>& things) {
  RayScene scene;
  scene.add(make_box({2.0, 2.0, 0.02}), make_pose({0.0, 0.0, -0.01}));
  for (const auto& [mesh, T_W_A] : things) scene.add(mesh, T_W_A);
  scene.commit();
  CameraIntrinsics camera;
  camera.width = 320, camera.height = 240;
  camera.fx = camera.fy = 240.0;
  camera.cx = 159.5, camera.cy = 119.5;
  const Pose T_W_C = camera_looking_at({0.15, -0.1, 0.5}, {0.0, 0.0, 0.03}, 0.0);
  return {render(scene, camera, T_W_C).depth, T_W_C};
}

bool refuted_by(const std::vector<std::pair<Mesh, Pose>>& things) {
  return is_refuted({view_of(things)}, stone(), kPlace);
}

TEST(RefutedPlace, OfAStoneThatIsThereIsNotRefuted) {
  EXPECT_FALSE(refuted_by({{stone(), kPlace}}));
  EXPECT_FALSE(refuted_by({{stone(), make_pose({0.004, 0.003, 0.025})}})) << "poses err by millimetres";
}

TEST(RefutedPlace, WhereTheTableIsSeenInstead) {
  EXPECT_TRUE(refuted_by({}));
  EXPECT_TRUE(refuted_by({{stone(), make_pose({0.12, 0.0, 0.025})}})) << "it lies beside its place";
}

TEST(RefutedPlace, AStoneThatFellOverIsNotThere) {
  Pose lying = make_pose({0.05, 0.0, 0.04});
  lying.rotate(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitY()));
  EXPECT_TRUE(refuted_by({{stone(), lying}}));
}

TEST(RefutedPlace, AHiddenStoneMayBeThere) {
  const std::pair<Mesh, Pose> roof{make_box({0.3, 0.3, 0.02}), make_pose({0.0, 0.0, 0.12})};
  EXPECT_FALSE(refuted_by({roof}));
  EXPECT_FALSE(is_refuted({}, stone(), kPlace)) << "no view of it";
}

TEST(RefutedPlace, OneViewOfSeveralIsEnoughToRefute) {
  const std::pair<Mesh, Pose> roof{make_box({0.3, 0.3, 0.02}), make_pose({0.0, 0.0, 0.12})};
  EXPECT_TRUE(is_refuted({view_of({roof}), view_of({})}, stone(), kPlace));
}

TEST(RefutedPlace, AStoneThatWasJustSetDownHasToBeRecognised) {
  stonestack::test::UnknownPile pile({1_stone, 3_stone});
  pile.options.detection.accept_score = 1.0;  // no stone is recognised
  EXPECT_TRUE(pile.observed().stack.empty());
  const simulation::Truth lying = pile.cell.truth();  // the upper one has come to rest
  const auto tower = as_estimates({{0_stone, at(lying.T_W_O, 1_stone)}, {1_stone, at(lying.T_W_O, 3_stone)}});
  EXPECT_EQ(pile.observed(tower, false).stack.size(), 2U);
  EXPECT_EQ(pile.observed(tower, true).stack.size(), 1U);
}

}  // namespace
}  // namespace stonestack::stacking
