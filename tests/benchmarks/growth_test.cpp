#include "benchmarks/growth.hpp"

#include <gtest/gtest.h>

namespace stonestack::bench {
namespace {

TEST(Growth, TheMedianSlopeIsThatOfALineAndKeepsToItWithAnOutlier) {
  std::vector<double> samples;
  for (int k = 0; k < 20; ++k) samples.push_back(100.0 + 0.25 * k);
  EXPECT_DOUBLE_EQ(median_slope(samples), 0.25);
  samples[19] = 1e6;
  samples[3] = -1e6;
  EXPECT_NEAR(median_slope(samples), 0.25, 1e-9);
  EXPECT_EQ(median_slope({7.0}), 0.0);
}

TEST(Growth, ASawtoothDoesNotGrow) {
  std::vector<double> samples;
  for (int k = 0; k < 30; ++k) samples.push_back(150.0 + k % 3);
  EXPECT_NEAR(median_slope(samples), 0.0, 0.01);
}

TEST(Growth, TheWarmUpIsAQuarterAndFiveAtLeast) {
  EXPECT_EQ(after_warm_up(std::vector<double>(100, 1.0)).size(), 75U);
  EXPECT_EQ(after_warm_up({1, 2, 3, 4, 5, 6, 7}), (std::vector<double>{6, 7}));
  EXPECT_TRUE(after_warm_up({1, 2, 3}).empty());
}

}  // namespace
}  // namespace stonestack::bench
