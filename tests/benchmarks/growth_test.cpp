#include "benchmarks/growth.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

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

TEST(Growth, TheExponentIsThatOfAPowerLaw) {
  std::vector<CostPoint> points;
  for (const double size : {20.0, 50.0, 100.0, 200.0}) points.push_back({size, 3.0 * std::pow(size, 1.5)});
  EXPECT_NEAR(growth_exponent(points), 1.5, 1e-12);
  EXPECT_FALSE(std::isfinite(growth_exponent({{20.0, 1.0}})));
}

TEST(Growth, ThePlotHasEachPointInItsPlace) {
  const std::string plot = growth_plot({{50.0, 1.0}, {100.0, 4.0}}, "stones", "seconds");
  EXPECT_THAT(plot, testing::HasSubstr(">stones</text>"));
  EXPECT_THAT(plot, testing::HasSubstr(">seconds; dashed: linear</text>"));
  // The right half of 400 units from x = 60; 250 units up from y = 270 are 1.1 times the highest cost.
  EXPECT_THAT(plot, testing::HasSubstr("<circle cx=\"260\" cy=\"213.182\""));
  EXPECT_THAT(plot, testing::HasSubstr("<circle cx=\"460\" cy=\"42.7273\""));
}

}  // namespace
}  // namespace stonestack::bench
