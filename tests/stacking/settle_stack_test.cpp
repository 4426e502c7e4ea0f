#include "stacking/steady.hpp"

#include <gtest/gtest.h>

#include "box_shape.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kFriction = 0.4;

/// A slab, and a narrow one that stands on its edge: it falls when it is set down askew.
const ShapeList& slabs() {
  static const ShapeList list = {box("wide", {0.12, 0.12, 0.05}), box("narrow", {0.06, 0.016, 0.05})};
  return list;
}

Stack two(double lift, double tilt) {
  const Eigen::Quaterniond R_W_O(Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX()));
  return {{{0, make_pose({0, 0, 0.025})}, {1, make_pose({0, 0, 0.075 + lift}, R_W_O)}}};
}

bool stands(const Stack& stack) {
  StandOptions stand;
  stand.friction = kFriction;
  stand.seconds = 1.0;
  const StandVerdict verdict = judge_stack(slabs(), stack, stand);
  return verdict.stands && verdict.clean;
}

TEST(Steadied, AStackThatStandsIsLeftAsItIs) {
  const Stack seen = two(0.0, 0.0);
  const Stack steady = steadied(slabs(), seen, kFriction);
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_EQ(steady.stones[i].T_W_O.matrix(), seen.stones[i].T_W_O.matrix());
}

TEST(Steadied, WhatFloatsByTheCamerasErrorIsLetDown) {
  const Stack seen = two(0.0015, 0.0);
  ASSERT_FALSE(stands(seen)) << "1.5 mm above: it falls by more than a stack that stands may move";
  const Stack steady = steadied(slabs(), seen, kFriction);
  EXPECT_TRUE(stands(steady));
  EXPECT_NEAR(steady.stones[1].T_W_O.translation().z(), 0.075, 1e-4);
}

/// A slab that was seen 2 deg askew stands upright; one that was seen 21 deg askew is none that stands.
TEST(Steadied, ALittleTiltIsRightedAndMuchIsNot) {
  const Stack seen = two(0.001, 0.36);
  ASSERT_FALSE(stands(seen));
  const Stack steady = steadied(slabs(), seen, kFriction);
  EXPECT_EQ(steady.stones[1].T_W_O.matrix(), seen.stones[1].T_W_O.matrix()) << "21 deg are no camera's error";
  const Stack little = steadied(slabs(), two(0.001, 0.03), kFriction);
  EXPECT_TRUE(stands(little));
  EXPECT_LT(off_measured(little.stones[1].T_W_O, two(0.001, 0.03).stones[1].T_W_O), kConsistent);
}

/// Its centre of mass is seen 0.3 mm beyond the edge: let down there it falls, a millimetre further in it
/// stands.
TEST(Steadied, PosesBesideTheMeasuredOneAreTried) {
  Stack seen = two(0.0, 0.0);
  seen.stones[1].T_W_O.translation().x() = 0.0603;
  ASSERT_FALSE(stands(seen));
  const Stack steady = steadied(slabs(), seen, kFriction);
  EXPECT_TRUE(stands(steady));
  EXPECT_LT(steady.stones[1].T_W_O.translation().x(), 0.060);
  EXPECT_LT(off_measured(steady.stones[1].T_W_O, seen.stones[1].T_W_O), kBelievable);
  EXPECT_EQ(steadied(slabs(), seen, kFriction).stones[1].T_W_O.matrix(), steady.stones[1].T_W_O.matrix());
}

TEST(Steadied, WhatIsTooFarFromStandingStaysAsItWasSeen) {
  const Stack seen = two(0.05, 0.0);
  EXPECT_EQ(steadied(slabs(), seen, kFriction).stones[1].T_W_O.matrix(), seen.stones[1].T_W_O.matrix());
}

}  // namespace
}  // namespace stonestack::stacking
