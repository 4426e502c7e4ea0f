#include "motion/clearance_below.hpp"

#include <gtest/gtest.h>

#include "kinematics/inverse.hpp"
#include "motion/constants.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::motion {
namespace {

/// The hand points down with its finger tips 12 mm above a tower that is `width` wide, or above the table.
struct OverATower {
  PlanningScene scene;
  Joints q;

  explicit OverATower(double width, double height = 0.10) {
    scene.robot = read_robot("ur10");
    scene.T_F_T = Pose(Eigen::Translation3d(0, 0, 0.264));
    if (height > 0)
      scene.objects.push_back(
          {"tower", {make_box({width, width, height})}, Pose(Eigen::Translation3d(0.70, 0.20, height / 2))});
    const Pose T_W_T =
        Eigen::Translation3d(0.70, 0.20, height + 0.012) * Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX());
    Joints seed;
    seed << 0.0, -1.8, 1.8, -1.57, -1.57, 0.0;
    q = inverse(scene.robot, scene.T_W_R.inverse() * T_W_T * scene.T_F_T.inverse(), seed).front().q;
  }
  [[nodiscard]] double clearance(double max = 0.015, double opening = 0.08) const {
    return clearance_below(scene, q, opening, -1, max);
  }
};

TEST(ClearanceBelow, EndsAboveWhatFingersWouldMeet) {
  const OverATower wide(0.20);
  const double clear = 0.012 - kDescentPadding;
  EXPECT_LE(wide.clearance(), clear);
  EXPECT_GE(wide.clearance(), clear - 0.001);
  EXPECT_EQ(wide.clearance(0.010), 0.010) << "no further than asked for";
}

TEST(ClearanceBelow, IsWholeWhereFingersPassBeside) {
  const OverATower narrow(0.05);
  EXPECT_EQ(narrow.clearance(), 0.015);
  EXPECT_LT(narrow.clearance(0.015, 0.03), 0.013) << "closed further they come down on it";
}

TEST(ClearanceBelow, FingersMayFeelTheTable) {
  const OverATower none(0.20, 0.0);
  EXPECT_EQ(none.clearance(), 0.015);
  OverATower kept = none;
  kept.scene.paddings = {{"hand", "table", 0.007}};
  EXPECT_LE(kept.clearance(), 0.005) << "12 mm above it, and 7 are asked for";
  EXPECT_THROW((void)none.clearance(-0.001), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::motion
