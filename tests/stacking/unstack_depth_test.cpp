#include "stacking/unstack_depth.hpp"

#include <gtest/gtest.h>

namespace stonestack::stacking {
namespace {

TEST(UnstackDepth, GoesAsDeepAsTheBestTowerBegins) {
  // There are towers of four above each stone, but only the deepest is likely to stand.
  EXPECT_EQ(unstack_depth({2.4, 2.7, 3.7}, 0), 3u);
}

TEST(UnstackDepth, TakesNoMoreThanIsWorthIt) {
  EXPECT_EQ(unstack_depth({3.6, 3.7, 3.9}, 0), 1u) << "a tenth of a stone is less than two motions are worth";
  EXPECT_EQ(unstack_depth({3.6, 3.9, 3.9}, 0), 2u);
}

TEST(UnstackDepth, PassesOverWhatLeadsNowhere) {
  EXPECT_EQ(unstack_depth({0.0, 0.0, 3.2}, 0), 3u);
  EXPECT_EQ(unstack_depth({0.0, 2.5}, 2), 2u) << "nothing higher was found above the first";
}

TEST(UnstackDepth, LeavesTheStackWhereNothingPromisesMore) {
  EXPECT_EQ(unstack_depth({}, 0), 0u);
  EXPECT_EQ(unstack_depth({3.0, 3.4}, 3), 0u) << "two unstacked cost as much as is gained";
  EXPECT_EQ(unstack_depth({3.0, 3.5}, 3), 2u);
  EXPECT_EQ(unstack_depth({0.0, 0.0}, 0), 0u);
}

}  // namespace
}  // namespace stonestack::stacking
