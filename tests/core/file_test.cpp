#include "stonestack/core/file.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "stonestack/core/error.hpp"

namespace stonestack::core {
namespace {

namespace fs = std::filesystem;

TEST(File, WritesWholeAndMakesFolders) {
  const fs::path folder = fs::path(testing::TempDir()) / "file_test" / "a";
  fs::remove_all(folder.parent_path());
  write_file((folder / "x.txt").string(), "one");
  write_file((folder / "x.txt").string(), "two");
  EXPECT_EQ(read_file((folder / "x.txt").string(), 10), "two");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1) << "a temporary file was left behind";
  fs::remove_all(folder.parent_path());
}

TEST(File, RefusesWhatIsNotAFile) {
  EXPECT_THROW((void)read_file("/nonexistent/file", 10), FileError);
  EXPECT_THROW((void)read_file("/tmp", 10), FileError);
  EXPECT_THROW((void)read_file("/dev/zero", 10), FileError);
  EXPECT_THROW(write_file("/proc/nonexistent/x", "one"), FileError);
}

TEST(File, RefusesWhatIsTooLarge) {
  const std::string path = testing::TempDir() + "file_test_large";
  write_file(path, "12345");
  EXPECT_THROW((void)read_file(path, 4), FileError);
  fs::remove(path);
}

}  // namespace
}  // namespace stonestack::core
