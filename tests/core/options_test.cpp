#include "stonestack/core/options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::core {
namespace {

using ::testing::HasSubstr;

struct Sample {
  double friction = 0.1;
  int beam = 3;
  bool noise = true;
  std::string method = "default";
};

FieldList fields(Sample& s) {
  return {field("friction", s.friction, {0, 2}, "", "paper"),
          field("beam", s.beam, {1, 9}, "", "design choice"), field("noise", s.noise, "design choice"),
          field("method", s.method, "design choice")};
}

std::string problem_of(const std::string& assignment) {
  Sample sample;
  try {
    set_field(fields(sample), assignment);
  } catch (const InvalidArgument& error) {
    return error.what();
  }
  return "";
}

TEST(Options, SetsEveryKind) {
  Sample sample;
  for (const char* text : {"friction=0.5", "beam=4", "noise=false", "method=paper"})
    set_field(fields(sample), text);
  EXPECT_DOUBLE_EQ(sample.friction, 0.5);
  EXPECT_EQ(sample.beam, 4);
  EXPECT_FALSE(sample.noise);
  EXPECT_EQ(sample.method, "paper");
}

TEST(Options, RefusesWithNameValueAndRange) {
  EXPECT_THAT(problem_of("friction=3"), HasSubstr("friction must be in [0, 2], got 3"));
  EXPECT_THAT(problem_of("friction=nan"), HasSubstr("got 'nan'"));
  EXPECT_THAT(problem_of("beam=2.5"), HasSubstr("whole number"));
  EXPECT_THAT(problem_of("noise=yes"), HasSubstr("true or false"));
  EXPECT_THAT(problem_of("fricton=1"), HasSubstr("did you mean friction"));
  EXPECT_THAT(problem_of("friction"), HasSubstr("name=value"));
}

TEST(Options, SuggestsTheWholeNameWhereTheGroupWasLeftOut) {
  Sample first, second;
  const FieldList list = join({nest("search", fields(first)), nest("simulation", fields(second))});
  try {
    set_field(list, "beem=2");
    FAIL();
  } catch (const InvalidArgument& error) {
    EXPECT_THAT(error.what(), testing::EndsWith("did you mean search.beam or simulation.beam?"));
  }
}

TEST(Options, AWordThatIsNoSlipOfANameIsNotGuessedAt) {
  EXPECT_THAT(problem_of("temperature=20"), testing::EndsWith("unknown option 'temperature'"));
  Sample sample;
  try {
    set_field(nest("search", fields(sample)), "camera.exposure=3");
    FAIL();
  } catch (const InvalidArgument& error) {
    EXPECT_THAT(error.what(), testing::Not(HasSubstr("did you mean")));
  }
}

TEST(Options, ANameThatTwoListsHaveIsOfferedOnce) {
  Sample first, second;
  try {
    set_field(join({nest("search", fields(first)), nest("search", fields(second))}), "search.beem=2");
    FAIL();
  } catch (const InvalidArgument& error) {
    EXPECT_THAT(error.what(), HasSubstr("did you mean search.beam"));
    EXPECT_THAT(error.what(), testing::Not(HasSubstr("search.beam, search.beam")));
  }
}

TEST(Options, AreForExpertsUnlessMarkedForUsers) {
  Sample sample;
  const FieldList list =
      nest("search", FieldList{user(field("friction", sample.friction, {0, 2}, "", "of stones")),
                               field("beam", sample.beam, {1, 9}, "", "towers kept")});
  ASSERT_EQ(user_fields(list).size(), 1U);
  EXPECT_EQ(user_fields(list).front().name, "search.friction");
  EXPECT_EQ(user_fields(user(list)).size(), 2U);
  set_field(list, "search.beam=5");
  EXPECT_EQ(sample.beam, 5) << "an option for experts is set like any other";
}

TEST(Options, FileRoundTripAndUnknownKey) {
  const std::string path = test::temporary_folder() + "options_test.yaml";
  Sample written{0.35, 7, false, "paper"};
  write_file(path, write_fields(fields(written)));
  Sample read;
  read_fields(fields(read), path);
  EXPECT_DOUBLE_EQ(read.friction, 0.35);
  EXPECT_EQ(read.beam, 7);
  EXPECT_FALSE(read.noise);
  EXPECT_EQ(read.method, "paper");

  write_file(path, "beams: 3\n");
  try {
    read_fields(fields(read), path);
    FAIL();
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr(path));
    EXPECT_THAT(error.what(), HasSubstr("unknown option 'beams'; did you mean beam"));
  }
  std::filesystem::remove(path);
}

TEST(Options, FileMayHoldWhatOthersKnow) {
  const std::string path = test::temporary_folder() + "options_others.yaml";
  Sample mine, other;
  const auto others = nest("other", fields(other));
  write_file(path, "friction: 0.3\nother:\n  friction: 0.4\n");
  read_fields(fields(mine), path, others);
  EXPECT_DOUBLE_EQ(mine.friction, 0.3);
  EXPECT_DOUBLE_EQ(other.friction, 0.4);
  write_file(path, "other.friction: 7\n");
  EXPECT_THROW(read_fields(fields(mine), path, others), FileError);
  write_file(path, "other.colour: red\n");
  EXPECT_THROW(read_fields(fields(mine), path, others), FileError);
  EXPECT_THROW(read_fields(fields(mine), path), FileError);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace stonestack::core
