#include "stonestack/geometry/obstacle.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stonestack/core/error.hpp"

namespace stonestack::geometry {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::vector<std::string> kObstacles{"wall", "lamp"};

std::string padding_problem_of(const std::string& text) {
  try {
    (void)parse_pair_paddings(text, "cell.yaml", "layout.padding", kObstacles);
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

TEST(PairPadding, ReadsWhoStaysHowFarFromWhat) {
  const auto list = parse_pair_paddings("- {a: hand, b: table, m: 0.004}\n- {a: wrist 2, b: lamp, m: 0.1}\n",
                                        "cell.yaml", "layout.padding", kObstacles);
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[0].a, "hand");
  EXPECT_EQ(list[0].b, "table");
  EXPECT_DOUBLE_EQ(list[0].m, 0.004);
  EXPECT_EQ(list[1].a, "wrist 2");
  EXPECT_TRUE(parse_pair_paddings("", "cell.yaml", "layout.padding", {}).empty());
}

TEST(PairPadding, RefusesWithFileKeyAndValue) {
  EXPECT_THAT(padding_problem_of("hand"), HasSubstr("cell.yaml: layout.padding is not a list"));
  EXPECT_THAT(padding_problem_of("- {a: hands, b: table, m: 0.1}"),
              AllOf(HasSubstr("layout.padding[0]"), HasSubstr("'hands'"), HasSubstr("arm, hand, held")));
  EXPECT_THAT(padding_problem_of("- {a: hand, b: floor, m: 0.1}"),
              AllOf(HasSubstr("'floor'"), HasSubstr("table, wall, lamp")));
  EXPECT_THAT(padding_problem_of("- {a: hand, b: table, m: -0.1}"), HasSubstr("-0.1"));
  EXPECT_THAT(padding_problem_of("- {a: hand, b: table, m: .nan}"), HasSubstr("layout.padding[0].m"));
  EXPECT_THAT(padding_problem_of("- {a: shoulder, b: table, m: 0.1}"), HasSubstr("stands on the table"));
  EXPECT_THAT(padding_problem_of("- {a: hand, b: table}"), HasSubstr("m is missing"));
  EXPECT_THAT(padding_problem_of("- {a: hand, b: table, m: 0.1, mm: 3}"), HasSubstr("mm"));
}

}  // namespace
}  // namespace stonestack::geometry
