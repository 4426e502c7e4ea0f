#include "hardware/guard_readings.hpp"

#include <gtest/gtest.h>

namespace stonestack::hardware {
namespace {

TEST(GuardReadings, MeanOfTheSecondHalf) {
  GuardReadings readings;
  EXPECT_EQ(readings.mean_of_second_half(), 0.0);
  for (const double force : {9.0, 9.0, 1.0, 2.0, 3.0}) readings.add(force);
  EXPECT_NEAR(readings.mean_of_second_half(), 2.0, 1e-12);
}

}  // namespace
}  // namespace stonestack::hardware
