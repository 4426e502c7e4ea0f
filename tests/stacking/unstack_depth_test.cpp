#include "stacking/take_off_depth.hpp"

#include <gtest/gtest.h>

namespace stonestack::stacking {
namespace {

TEST(TakeOffDepth, GoesAsDeepAsTheBestWayBegins) {
  // Seed 5026119: there was a way to four above each stone, but hardly one that would stand; the first was
  // taken six times.
  EXPECT_EQ(take_off_depth({2.4, 2.7, 3.7}), 3u);
}

TEST(TakeOffDepth, TakesNoMoreThanIsWorthIt) {
  EXPECT_EQ(take_off_depth({3.6, 3.7, 3.9}), 1u) << "a tenth of a stone is less than two motions are worth";
  EXPECT_EQ(take_off_depth({3.6, 3.9, 3.9}), 2u);
}

TEST(TakeOffDepth, PassesOverWhatLeadsNowhere) {
  EXPECT_EQ(take_off_depth({0.0, 0.0, 3.2}), 3u);
  EXPECT_EQ(take_off_depth({0.0, 0.1}), 2u) << "nothing higher was found above the first";
}

TEST(TakeOffDepth, LeavesTheStackWhereNothingPromisesMore) {
  EXPECT_EQ(take_off_depth({}), 0u);
  EXPECT_EQ(take_off_depth({0.0, 0.0}), 0u);
}

}  // namespace
}  // namespace stonestack::stacking
