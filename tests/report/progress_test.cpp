#include <gtest/gtest.h>

#include "stonestack/report/results.hpp"

namespace stonestack::report {
namespace {

TEST(Progress, NamesWhatHowFarBestAndTimeLeft) {
  EXPECT_EQ(progress_text({"experiment", 3, 12, "runs", "mean height 3.33", 60}),
            "experiment: 3 of 12 runs, mean height 3.33, about 3 min left");
  EXPECT_EQ(progress_text({"search", 20, 60, "s", "4.1 expected", 20}),
            "search: 20 of 60 s, 4.1 expected, about 40 s left");
  EXPECT_EQ(progress_text({"experiment", 1, 101, "runs", "", 360}),
            "experiment: 1 of 101 runs, about 10.0 h left");
}

TEST(Progress, NamesNoTimeThatCannotBeKnown) {
  EXPECT_EQ(progress_text({"scan", 0, 6, "stones", "now rock", 0}), "scan: 0 of 6 stones, now rock");
  EXPECT_EQ(progress_text({"search", 7, 0, "s", "", 7}), "search: 7 s");
  EXPECT_EQ(progress_text({"tower", 4, 4, "stones", "", 90}), "tower: 4 of 4 stones");
}

}  // namespace
}  // namespace stonestack::report
