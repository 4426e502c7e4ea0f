#include "stacking/journal.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::stacking {
namespace {

TEST(Journal, AppendsNumbersAndSurvivesATornTail) {
  const std::string path = test::temporary_folder() + "journal_test.jsonl";
  std::filesystem::remove(path);
  {
    Journal journal(path);
    journal.record("intent", "{\"step\": 1}");
    journal.record("done", "{}");
  }
  write_file(path, read_file(path, 1000) + "{\"seq\": 2, \"ki");  // the power went out here
  {
    Journal journal(path);
    journal.record("intent", "3");
  }
  EXPECT_EQ(read_file(path, 1000), R"({"seq":0,"kind":"intent","data":{"step":1}})"
                                   "\n"
                                   R"({"seq":1,"kind":"done","data":{}})"
                                   "\n"
                                   R"({"seq":2,"kind":"intent","data":3})"
                                   "\n");
  std::filesystem::remove(path);
}

TEST(Journal, ReportsWhenTheDiskRefuses) {
  EXPECT_THROW(Journal("/proc/nowhere/journal.jsonl"), FileError);
  Journal journal("/dev/full");
  EXPECT_THROW(journal.record("intent", "{}"), FileError);
}

TEST(Journal, DefaultMadeRecordsNothing) {
  Journal journal;
  EXPECT_NO_THROW(journal.record("intent", "{}"));
}

}  // namespace
}  // namespace stonestack::stacking
