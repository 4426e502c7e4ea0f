#include "stonestack/core/clock.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace stonestack::core {
namespace {

double steady() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

TEST(SteadyClock, IsWhatDeadlinesAndWatchesGoBy) {
  const double before = steady();
  const double now = host_seconds();
  EXPECT_LE(before, now);
  EXPECT_LE(now, steady()) << "not the time of day, which people and servers set";
}

}  // namespace
}  // namespace stonestack::core
