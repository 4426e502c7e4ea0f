#include "stacking/mount_correction.hpp"

#include <gtest/gtest.h>

namespace stonestack::stacking {
namespace {

MountRefinement refinement() {
  MountRefinement found;
  found.T_T_C = make_pose({0.001, 0.0, -0.26});
  found.shift = 0.002;
  found.turn = 0.005;
  found.after = 0.0005;
  found.table_W = {Eigen::Vector3d::UnitZ(), 0.004};
  return found;
}

TEST(MountCorrection, TheTableComesToLieInZeroAndTheRobotMoves) {
  CellLayout layout;
  const Pose T_W_R = layout.T_W_R;
  const MountCorrection correction = correction_of(refinement(), layout);
  ASSERT_TRUE(correction.accepted);
  EXPECT_NEAR(correction.height, 0.004, 1e-12);
  EXPECT_NEAR((correction.T_level * Eigen::Vector3d(0.5, -0.2, 0.004)).z(), 0.0, 1e-12);
  apply(correction, layout);
  EXPECT_TRUE(layout.T_T_C.isApprox(refinement().T_T_C));
  EXPECT_NEAR(layout.T_W_R.translation().z(), T_W_R.translation().z() - 0.004, 1e-12);
}

TEST(MountCorrection, MoreThanACalibrationErrsIsNotBelieved) {
  const CellLayout layout;
  auto hit = refinement();
  hit.shift = 0.012;
  EXPECT_FALSE(correction_of(hit, layout).accepted);
  auto turned = refinement();
  turned.turn = 0.04;
  EXPECT_FALSE(correction_of(turned, layout).accepted);
  auto torn = refinement();
  torn.after = 0.004;
  EXPECT_FALSE(correction_of(torn, layout).accepted);
  auto high = refinement();
  high.table_W.offset = 0.03;
  EXPECT_FALSE(correction_of(high, layout).accepted);
  auto tilted = refinement();
  tilted.table_W.normal = Eigen::Vector3d(0.05, 0.0, 1.0).normalized();
  tilted.table_W.offset = tilted.table_W.normal.x() * layout.field_centre.x();
  EXPECT_FALSE(correction_of(tilted, layout).accepted);
}

}  // namespace
}  // namespace stonestack::stacking
