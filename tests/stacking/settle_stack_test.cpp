#include "stacking/settle_stack.hpp"

#include <gtest/gtest.h>

#include "box_shape.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kFriction = 0.4;

/// A slab, and a narrow one that stands on its edge: it falls when it is set down askew.
const ShapeList& stack_of_slabs() {
  static const ShapeList list = {box("wide", {0.12, 0.12, 0.05}), box("narrow", {0.06, 0.016, 0.05})};
  return list;
}

/// The stack as it rests when it was measured like that; `lowered`: its stones are let down one by one
/// first.
Stack settled(const Stack& seen, bool lowered = false) {
  std::vector<MeasuredStone> measured;
  for (const StoneEstimate& stone : as_estimates(seen.stones)) measured.push_back({stone, lowered});
  Stack stack;
  for (const StoneEstimate& stone : settle_stack(stack_of_slabs(), measured, kFriction))
    stack.stones.push_back({stone.stone, stone.T_W_O_at_rest});
  return stack;
}

Stack two(double lift, double tilt) {
  const Eigen::Quaterniond R_W_O(Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX()));
  return {{{0_stone, make_pose({0, 0, 0.025})}, {1_stone, make_pose({0, 0, 0.075 + lift}, R_W_O)}}};
}

bool stands(const Stack& stack) {
  StandOptions stand;
  stand.friction = kFriction;
  stand.seconds = 1.0;
  const StandVerdict verdict = judge_stack(stack_of_slabs(), stack, stand);
  return verdict.stands && verdict.clean;
}

TEST(SettleStack, AStableStackIsLeftAsItIs) {
  const Stack seen = two(0.0, 0.0);
  const Stack resting = settled(seen);
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_EQ(resting.stones[i].T_W_O.matrix(), seen.stones[i].T_W_O.matrix());
}

TEST(SettleStack, AStoneThatFloatsByTheCamerasErrorIsLowered) {
  const Stack seen = two(0.0015, 0.0);
  ASSERT_FALSE(stands(seen)) << "1.5 mm above: it falls by more than a stack that stands may move";
  const Stack resting = settled(seen);
  EXPECT_TRUE(stands(resting));
  EXPECT_NEAR(resting.stones[1].T_W_O.translation().z(), 0.075, 1e-4);
}

/// A slab that was seen 2 deg askew stands upright; one that was seen 21 deg askew does not.
TEST(SettleStack, ALittleTiltIsRightedAndMuchIsNot) {
  const Stack seen = two(0.001, 0.36);
  ASSERT_FALSE(stands(seen));
  const Stack resting = settled(seen);
  EXPECT_EQ(resting.stones[1].T_W_O.matrix(), seen.stones[1].T_W_O.matrix())
      << "the camera does not err by 21 deg";
  const Stack little = settled(two(0.001, 0.03));
  EXPECT_TRUE(stands(little));
  EXPECT_LT(off_measured(little.stones[1].T_W_O, two(0.001, 0.03).stones[1].T_W_O), kConsistent);
}

/// Its centre of mass is seen 0.3 mm beyond the edge: let down there it falls, a millimetre further in it
/// stands.
TEST(SettleStack, PosesBesideTheMeasuredOneAreTried) {
  Stack seen = two(0.0, 0.0);
  seen.stones[1].T_W_O.translation().x() = 0.0603;
  ASSERT_FALSE(stands(seen));
  const Stack resting = settled(seen);
  EXPECT_TRUE(stands(resting));
  EXPECT_LT(resting.stones[1].T_W_O.translation().x(), 0.060);
  EXPECT_LT(off_measured(resting.stones[1].T_W_O, seen.stones[1].T_W_O), kMaxMeasured);
  EXPECT_EQ(settled(seen).stones[1].T_W_O.matrix(), resting.stones[1].T_W_O.matrix());
}

TEST(SettleStack, AnUnstableStackStaysAsItWasSeen) {
  const Stack seen = two(0.05, 0.0);
  EXPECT_EQ(settled(seen).stones[1].T_W_O.matrix(), seen.stones[1].T_W_O.matrix());
}

/// A stone that was seen 1.5 mm above its support is let down on it, and what was seen is kept beside that.
TEST(SettleStack, WhereAStoneWasSeenStaysApartFromWhereItRests) {
  const Stack seen = two(0.0015, 0.0);
  std::vector<MeasuredStone> measured;
  for (const StoneEstimate& stone : as_estimates(seen.stones)) measured.push_back({stone, true});
  const auto estimates = settle_stack(stack_of_slabs(), measured, kFriction);
  ASSERT_EQ(estimates.size(), 2U);
  EXPECT_EQ(estimates[1].T_W_O_seen.matrix(), seen.stones[1].T_W_O.matrix());
  EXPECT_NEAR(estimates[1].T_W_O_at_rest.translation().z(), 0.075, 1e-4);
}

TEST(RestingStacks, ReportTheFrictionsAtWhichAStackIsStable) {
  Stack stack = two(0.0, 0.0);
  const auto resting = resting_stacks(stack_of_slabs(), stack, {}, {0.1, 0.4});
  ASSERT_EQ(resting.size(), 2U);
  for (const RestingStack& at : resting) EXPECT_TRUE(at.stack.has_value()) << at.reason;
  stack.stones[1].T_W_O.translation().x() = 0.075;  // its centre of mass is beyond the edge
  const auto falling = resting_stacks(stack_of_slabs(), stack, {}, {0.1, 0.4});
  for (const RestingStack& at : falling) {
    EXPECT_FALSE(at.stack.has_value());
    EXPECT_FALSE(at.reason.empty());
  }
}

}  // namespace
}  // namespace stonestack::stacking
