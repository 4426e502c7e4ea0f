#include "stone/file_units.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stonestack/core/error.hpp"

namespace stonestack::stone {
namespace {

using ::testing::HasSubstr;

std::string problem_of(double longest, const std::string& units, double scale) {
  try {
    (void)file_scale(longest, units, scale, "rock.obj");
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

TEST(FileUnits, AutoChoosesTheUnitThatMakesAGraspableStone) {
  const auto metres = [](double longest, double scale) {
    return file_scale(longest, "auto", scale, "rock.obj").metres_per_unit;
  };
  EXPECT_DOUBLE_EQ(metres(0.15, 1.0), 1.0);
  EXPECT_DOUBLE_EQ(metres(16.0, 1.0), 0.01);
  EXPECT_DOUBLE_EQ(metres(150.0, 1.0), 0.001);
  EXPECT_DOUBLE_EQ(metres(1.4, 0.12), 0.12);  // a boulder in metres, scaled down
}

TEST(FileUnits, WarnsOfAStoneThatNoGripperHolds) {
  EXPECT_TRUE(file_scale(0.15, "m", 1.0, "rock.obj").warnings.empty());
  EXPECT_EQ(file_scale(1.4, "m", 1.0, "rock.obj").warnings.size(), 1U);
  EXPECT_EQ(file_scale(3.0, "cm", 1.0, "rock.obj").warnings.size(), 1U);
}

TEST(FileUnits, RefusesWhatIsNoStoneWithValueAndRemedy) {
  EXPECT_THAT(problem_of(200.0, "m", 1.0),
              testing::AllOf(HasSubstr("rock.obj"), HasSubstr("200 m"), HasSubstr("--units mm")));
  EXPECT_THAT(problem_of(16.0, "m", 1.0), HasSubstr("--units cm"));
  EXPECT_THAT(problem_of(0.001, "m", 1.0), HasSubstr("--scale"));
  EXPECT_THAT(problem_of(2e5, "auto", 1.0), HasSubstr("--scale"));
  EXPECT_THAT(problem_of(0.0, "auto", 1.0), HasSubstr("0 m long"));
}

TEST(FileUnits, RefusesAnUnknownUnitAndAScaleOfNone) {
  EXPECT_THROW((void)file_scale(1.0, "inch", 1.0, "rock.obj"), InvalidArgument);
  EXPECT_THROW((void)file_scale(1.0, "m", 0.0, "rock.obj"), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::stone
