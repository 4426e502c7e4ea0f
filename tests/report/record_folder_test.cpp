#include "report/record_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::report {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class RecordFolderTest : public testing::Test {
 protected:
  void SetUp() override {
    root_ = test::temporary_folder() + concat("record_folder_test_", ::getpid());
    fs::remove_all(root_);
    fs::create_directories(root_);
  }
  void TearDown() override { fs::remove_all(root_); }
  [[nodiscard]] static std::string problem_of(const std::string& path) {
    try {
      const RecordFolder folder(path);
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  }

  std::string root_;
};

TEST_F(RecordFolderTest, IsHeldByOneAtATime) {
  const std::string path = root_ + "/runs/one/";
  {
    const RecordFolder first(path);
    EXPECT_TRUE(first.made());
    EXPECT_EQ(first.path(), root_ + "/runs/one");
    EXPECT_THAT(problem_of(path), HasSubstr("another program is writing its record there"));
    EXPECT_TRUE(fs::is_directory(path)) << "who was refused has removed it";
    write_file(path + "/journal.jsonl", "{}\n");
  }
  const RecordFolder again(path);
  EXPECT_FALSE(again.made());
}

TEST_F(RecordFolderTest, OfOneNameEachNewOneIsAnother) {
  const std::string path = root_ + "/runs/now";
  const RecordFolder one = RecordFolder::make_new(path), two = RecordFolder::make_new(path),
                     three = RecordFolder::make_new(path);
  EXPECT_EQ(one.path(), path);
  EXPECT_EQ(two.path(), path + "-2");
  EXPECT_EQ(three.path(), path + "-3");
  EXPECT_TRUE(one.made() && two.made() && three.made());
}

/// In a process of its own: 0 if it had the folder to itself, 3 if it was refused, 5 if somebody else was
/// there.
int hold_for_a_moment(const std::string& path) {
  try {
    const RecordFolder folder(path);
    if (::mkdir((path + "/held").c_str(), 0777) != 0) return 5;
    ::usleep(20000);
    return ::rmdir((path + "/held").c_str()) == 0 ? 0 : 5;
  } catch (const FileError&) {
    return 3;
  }
}

TEST_F(RecordFolderTest, OfManyProcessesNoTwoHaveItAtOnce) {
  const std::string path = root_ + "/runs/raced";
  std::vector<pid_t> children;
  for (int i = 0; i < 32; ++i) {
    const pid_t child = ::fork();
    if (child == 0) ::_exit(hold_for_a_moment(path));  // a lock ends with its process, too
    children.push_back(child);
  }
  int done = 0;
  for (const pid_t child : children) {
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_NE(WEXITSTATUS(status), 5) << "two had it at once";
    done += WEXITSTATUS(status) == 0 ? 1 : 0;
  }
  EXPECT_GE(done, 1);
  EXPECT_EQ(problem_of(path), "") << "a lock outlived its process";
}

TEST_F(RecordFolderTest, LeavesNothingBehindThatNothingWasWrittenTo) {
  { const RecordFolder folder(root_ + "/a/b/c"); }
  EXPECT_FALSE(fs::exists(root_ + "/a"));
  fs::create_directories(root_ + "/mine");
  { const RecordFolder folder(root_ + "/mine"); }
  EXPECT_TRUE(fs::exists(root_ + "/mine")) << "it was there before";
}

TEST_F(RecordFolderTest, PutsAsideWhatIsInIt) {
  write_file(root_ + "/run/journal.jsonl", "old\n");
  write_file(root_ + "/run-interrupted/journal.jsonl", "older\n");
  RecordFolder folder(root_ + "/run");
  EXPECT_EQ(folder.put_aside(), root_ + "/run-interrupted-2");
  EXPECT_TRUE(fs::is_empty(root_ + "/run"));
  EXPECT_EQ(read_file(root_ + "/run-interrupted-2/journal.jsonl", 100), "old\n");
  EXPECT_THAT(problem_of(root_ + "/run"), HasSubstr("another program"));
}

TEST_F(RecordFolderTest, GivesTheReasonWhereItCannotBeMade) {
  write_file(root_ + "/taken", "a file");
  EXPECT_THAT(problem_of(root_ + "/taken"), HasSubstr("Not a directory"));
  EXPECT_THAT(problem_of(root_ + "/taken/run"), HasSubstr("Not a directory"));
  EXPECT_THAT(problem_of("/sys/stonestack_record/run"),
              testing::AllOf(HasSubstr("the folder /sys/stonestack_record cannot be made"),
                             HasSubstr("--out"), testing::Not(HasSubstr("No such file"))));
}

}  // namespace
}  // namespace stonestack::report
