#include "stonestack/core/options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stonestack::core {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(Spelling, CountsTheLettersThatDiffer) {
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("friction", "friction"), 0U);
  EXPECT_EQ(edit_distance("fricton", "friction"), 1U);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
}

TEST(Spelling, ASlipIsMeantAndAnotherWordIsNot) {
  const std::vector<std::string> commands{"search", "scan", "simulate", "check"};
  EXPECT_THAT(likely_meant(commands, "serch"), ElementsAre("search"));
  EXPECT_THAT(likely_meant({"show", "init", "cell"}, "shwo"), ElementsAre("show")) << "neighbours swapped";
  EXPECT_THAT(likely_meant(commands, "sim"), ElementsAre("simulate")) << "the beginning of a name";
  EXPECT_THAT(likely_meant(commands, "frobnicate"), IsEmpty());
  EXPECT_THAT(likely_meant(commands, ""), IsEmpty());
  EXPECT_THAT(likely_meant({"--out", "--robot"}, "--robt"), ElementsAre("--robot")) << "the nearest alone";
}

}  // namespace
}  // namespace stonestack::core
