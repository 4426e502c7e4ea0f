#include "stonestack/core/file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "stonestack/core/error.hpp"
#include "temporary_folder.hpp"

namespace stonestack::core {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(File, WritesWholeAndMakesFolders) {
  const fs::path folder = fs::path(test::temporary_folder()) / "file_test" / "a";
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

/// Problem of a path, as `write_file` and `require_writable` say it; empty: nothing.
std::string problem_of(void (*call)(const std::string&), const std::string& path) {
  try {
    call(path);
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

TEST(File, NamesTheFolderThatCannotBeMade) {
  // Nobody makes folders there, not even root; the file that is missing in it is not the cause.
  const auto write = [](const std::string& path) { write_file(path, "one"); };
  const std::string problem = problem_of(write, "/sys/stonestack_file_test/x");
  EXPECT_THAT(problem,
              HasSubstr("/sys/stonestack_file_test/x: cannot be written: its folder cannot be made"));
  EXPECT_THAT(problem, Not(HasSubstr("No such file")));
}

TEST(File, WritesIntoADeviceAndLeavesItOne) {
  EXPECT_THROW(write_file("/dev/full", "one"), FileError);
  write_file("/dev/null", "one");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST(File, RefusesBeforehandWhereNothingCanBeWritten) {
  const fs::path folder = fs::path(test::temporary_folder()) / "file_test_writable";
  fs::remove_all(folder);
  write_file((folder / "taken").string(), "a file");
  EXPECT_EQ(problem_of(require_writable, folder / "new"), "");
  EXPECT_EQ(problem_of(require_writable, folder / "taken"), "") << "it may be replaced";
  EXPECT_EQ(problem_of(require_writable, folder / "a" / "b" / "new"), "");
  EXPECT_FALSE(fs::exists(folder / "a")) << "the check itself made a folder";
  EXPECT_THAT(problem_of(require_writable, folder), HasSubstr("it is a folder"));
  EXPECT_THAT(problem_of(require_writable, folder / "taken" / "new"), HasSubstr("taken is not a folder"));
  fs::create_directories(folder / "closed");
  fs::permissions(folder / "closed", fs::perms::owner_read | fs::perms::owner_exec);
  if (::geteuid() != 0) {  // root may write everywhere
    EXPECT_THAT(problem_of(require_writable, folder / "closed" / "new"), HasSubstr("Permission denied"));
  }
  fs::remove_all(folder);
}

TEST(File, RefusesWhatIsTooLarge) {
  const std::string path = test::temporary_folder() + "file_test_large";
  write_file(path, "12345");
  EXPECT_THROW((void)read_file(path, 4), FileError);
  fs::remove(path);
}

}  // namespace
}  // namespace stonestack::core
