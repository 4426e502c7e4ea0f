#include "stacking/friction_belief.hpp"

#include <gtest/gtest.h>

#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

TEST(FrictionBelief, BeginsWithMoreForMore) {
  const FrictionBelief belief({0.1, 0.225, 0.35, 0.475});
  for (std::size_t level = 0; level < 4; ++level)
    EXPECT_NEAR(belief.weight(level), 0.1 * static_cast<double>(level + 1), 1e-12);
  EXPECT_FALSE(belief.least_is_likeliest());
}

TEST(FrictionBelief, AFallThatMoreFrictionWouldNotHaveSeenTellsOfLess) {
  FrictionBelief belief({0.1, 0.225, 0.35, 0.475});
  belief.fell({0.0, 0.5, 1.0, 1.0});
  // By hand: 1 x 1, 2 x 0.625, 3 x 0.25, 4 x 0.25 of 4.
  EXPECT_NEAR(belief.weight(0), 0.25, 1e-12);
  EXPECT_NEAR(belief.weight(1), 0.3125, 1e-12);
  EXPECT_NEAR(belief.weight(2), 0.1875, 1e-12);
  EXPECT_NEAR(belief.weight(3), 0.25, 1e-12);
  belief.fell({0.0, 0.5, 1.0, 1.0});
  EXPECT_TRUE(belief.least_is_likeliest());
}

TEST(FrictionBelief, AFallThatNoFrictionExplainsTellsNothing) {
  FrictionBelief belief({0.1, 0.225});
  for (int k = 0; k < 100; ++k) belief.fell({1.0, 1.0});
  EXPECT_NEAR(belief.weight(0), 1.0 / 3.0, 1e-12);
}

TEST(FrictionBelief, WantsASuccessForEach) {
  FrictionBelief belief({0.1, 0.225});
  EXPECT_THROW(belief.fell({1.0}), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::stacking
