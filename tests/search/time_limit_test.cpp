#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>

#include "box_scenes.hpp"
#include "stonestack/core/clock.hpp"

namespace stonestack::search {
namespace {

/// Each reading of it takes a second.
class CountingClock : public Clock {
 public:
  mutable std::atomic<int> readings{0};
  [[nodiscard]] double now() const override { return readings++; }
};

TEST(FindNextPose, EndsSoonAfterTheTimeLimitWhateverItDoes) {
  const SearchProblem problem = base_stands();  // its shapes are made before the time runs
  for (const int seconds : {1, 20, 400}) {
    CountingClock clock;
    const TimeLimit limit(seconds, clock);
    const SearchResult result = find_next_pose(problem, quick());
    EXPECT_TRUE(limit.is_over());
    EXPECT_LT(clock.readings, seconds + 200) << "it went on after its time";
    if (result.best.empty()) {
      EXPECT_THAT(result.reason, ::testing::HasSubstr("the time was over"));
    }
    EXPECT_THAT(result.reason, ::testing::Not(::testing::HasSubstr("interrupted")));
  }
}

}  // namespace
}  // namespace stonestack::search
