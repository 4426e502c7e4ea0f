#include "stonestack/core/error.hpp"

#include <gtest/gtest.h>

namespace stonestack::core {
namespace {

TEST(Require, ThrowsWithTheValues) {
  try {
    require(false, "radius must be positive, got ", -0.5, " m");
    FAIL();
  } catch (const InvalidArgument& error) {
    EXPECT_STREQ(error.what(), "radius must be positive, got -0.5 m");
    EXPECT_EQ(error.exit_code(), ExitCode::kUsage);
  }
}

TEST(FileError, NamesFileProblemAndRemedy) {
  const FileError error("a.ply", "has 0 faces", "scan it again");
  EXPECT_STREQ(error.what(), "a.ply: has 0 faces; scan it again");
  EXPECT_EQ(error.exit_code(), ExitCode::kUnreadable);
}

}  // namespace
}  // namespace stonestack::core
