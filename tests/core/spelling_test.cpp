#include "stonestack/core/spelling.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stonestack::core {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(Spelling, RanksNamesByEditDistance) {
  EXPECT_THAT(nearest({"beam", "friction", "fractions"}, "fricton", 2), ElementsAre("friction", "fractions"));
  EXPECT_THAT(nearest({"b", "a"}, "c", 5), ElementsAre("b", "a")) << "equal ones keep their order";
  EXPECT_THAT(nearest({}, "c", 5), IsEmpty());
}

TEST(Spelling, ASlipIsMeantAndAnotherWordIsNot) {
  const std::vector<std::string> commands{"search", "scan", "simulate", "check"};
  EXPECT_THAT(likely_meant(commands, "serch"), ElementsAre("search"));
  EXPECT_THAT(likely_meant(commands, "sim"), ElementsAre("simulate")) << "the beginning of a name";
  EXPECT_THAT(likely_meant(commands, "frobnicate"), IsEmpty());
  EXPECT_THAT(likely_meant(commands, ""), IsEmpty());
}

}  // namespace
}  // namespace stonestack::core
