#include "stonestack/core/file.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "stonestack/core/error.hpp"
#include "temporary_folder.hpp"

namespace stonestack::core {
namespace {

TEST(DataPath, FindsWhatComesWithTheProjectAndPrefersTheGivenFolder) {
  EXPECT_TRUE(std::filesystem::exists(data_path("robots")));
  const std::string folder = test::temporary_folder() + "data_test";
  write_file(folder + "/robots/own.urdf", "<robot/>");
  setenv("STONESTACK_DATA", folder.c_str(), 1);
  EXPECT_EQ(data_path("robots"), folder + "/robots");
  unsetenv("STONESTACK_DATA");
  std::filesystem::remove_all(folder);
}

TEST(DataPath, ListsThePathsThatWereTried) {
  EXPECT_THROW((void)data_path("no_such_thing"), FileError);
}

}  // namespace
}  // namespace stonestack::core
