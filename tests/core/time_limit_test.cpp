#include "stonestack/core/clock.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "stonestack/core/error.hpp"

namespace stonestack::core {
namespace {

class SetClock : public Clock {
 public:
  double seconds = 100.0;
  [[nodiscard]] double now() const override { return seconds; }
};

TEST(TimeLimit, EndsWhatCanBeInterruptedOnceItsTimeIsOver) {
  SetClock clock;
  EXPECT_FALSE(time_is_over());
  {
    const TimeLimit limit(5.0, clock);
    clock.seconds = 104.9;
    EXPECT_FALSE(limit.is_over());
    EXPECT_NO_THROW(throw_if_interrupted());
    clock.seconds = 105.0;
    EXPECT_TRUE(limit.is_over());
    EXPECT_TRUE(time_is_over());
    EXPECT_TRUE(interrupt_noted());
    EXPECT_THROW(throw_if_interrupted(), Interrupted);
  }
  EXPECT_FALSE(time_is_over());
  EXPECT_FALSE(interrupt_noted()) << "only while it lives";
}

TEST(TimeLimit, OfZeroIsNone) {
  SetClock clock;
  const TimeLimit limit(0.0, clock);
  clock.seconds = 1e9;
  EXPECT_FALSE(limit.is_over());
  EXPECT_NO_THROW(throw_if_interrupted());
}

TEST(TimeLimit, IsTheOnlyOneOfItsProcess) {
  SetClock clock;
  std::optional<TimeLimit> first(std::in_place, 5.0, clock);
  EXPECT_THROW(TimeLimit(9.0, clock), InvalidArgument);
  clock.seconds = 105.0;
  EXPECT_TRUE(time_is_over()) << "the first one still counts";
  first.reset();
  EXPECT_NO_THROW(TimeLimit(9.0, clock));
}

}  // namespace
}  // namespace stonestack::core
