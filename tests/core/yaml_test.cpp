#include "core/yaml.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stonestack::core::yaml {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(YamlMap, RefusesMissingWrongAndUnknownKeys) {
  Map map(parse("{mass: 1.5, friction: nan, extra: 1}", "stone.yaml"), "stone.yaml");
  EXPECT_DOUBLE_EQ(map.number("mass"), 1.5);
  EXPECT_THROW((void)map.number("mass", 2, 3), FileError);
  EXPECT_THROW((void)map.number("friction"), FileError);
  EXPECT_THROW((void)map.number("density"), FileError);
  EXPECT_THROW(map.finish(), FileError);
}

TEST(YamlMap, RefusesWhatIsNotAMap) {
  EXPECT_THROW(Map(parse("[1, 2]", "a.yaml"), "a.yaml"), FileError);
  EXPECT_THROW((void)parse("{a: [}", "a.yaml"), FileError);
}

TEST(Yaml, RefusesAKeyThatAMapHasTwice) {
  const auto problem_of = [](const std::string& text) -> std::string {
    try {
      (void)parse(text, "cell.yaml");
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(problem_of("arm:\n  port: 1\n  port: 2\n"),
              AllOf(HasSubstr("cell.yaml"), HasSubstr("'port'"), HasSubstr("line 3")));
  EXPECT_THAT(problem_of("list:\n  - {a: 1, a: 2}\n"), HasSubstr("'a'"));
  EXPECT_EQ(problem_of("a: {x: 1}\nb: {x: 2}\n"), "");
}

TEST(Yaml, RefusesAKeyThatIsNoWord) {
  for (const char* text : {"{[a, b]: 1}", "{{a: b}: 1}", "? \n: 1", "a: {~: 1}"})
    EXPECT_THROW((void)parse(text, "cell.yaml"), FileError) << text;
}

TEST(YamlWalk, EndsOnAnAliasBomb) {
  std::string text = "a0: &a0 {x: 1}\n";
  for (int i = 1; i < 30; ++i) {
    const std::string below = "*a" + std::to_string(i - 1);
    text += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " {x: " + below + ", y: " + below + "}\n";
  }
  EXPECT_THROW(for_each_scalar(parse(text, "bomb.yaml"), [](const std::string&, const std::string&) {}),
               InvalidArgument);
}

}  // namespace
}  // namespace stonestack::core::yaml
