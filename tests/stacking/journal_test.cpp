#include "stacking/journal.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::stacking {
namespace {

/// Lines without time and checksum, which are checked on the way.
std::string checked_lines(const std::string& path) {
  std::istringstream in(read_file(path, 1 << 16));
  std::string content;
  for (std::string line; std::getline(in, line);) {
    EXPECT_FALSE(is_damaged(line)) << line;
    auto j = nlohmann::ordered_json::parse(line);
    EXPECT_EQ(j.at("time").get<std::string>().size(), std::string("2026-11-21T14:30:00.123Z").size());
    EXPECT_EQ(j.at("crc").get<std::string>().size(), 8U);
    j.erase("time");
    j.erase("crc");
    content += j.dump() + "\n";
  }
  return content;
}

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
  EXPECT_EQ(checked_lines(path), R"({"seq":0,"kind":"intent","data":{"step":1}})"
                                 "\n"
                                 R"({"seq":1,"kind":"done","data":{}})"
                                 "\n"
                                 R"({"seq":2,"kind":"intent","data":3})"
                                 "\n");
  std::filesystem::remove(path);
}

TEST(Journal, AnyLetterThatChangesIsNoticed) {
  const std::string path = test::temporary_folder() + "journal_crc.jsonl";
  Journal(path).record("step", R"({"name": "lift"})", R"({"q": [0.5], "force": 3})");
  std::string line = read_file(path, 1 << 16);
  line.pop_back();  // its end
  ASSERT_FALSE(is_damaged(line));
  EXPECT_EQ(nlohmann::json::parse(line).at("arm").at("force"), 3);
  for (std::size_t k = 0; k < line.size() - 2; ++k) {
    const std::size_t crc = line.find(",\"crc\"");
    if (k >= crc && k < crc + 8) continue;  // without the name of the checksum it is a line that has none
    std::string other = line;
    other[k] = other[k] == '0' ? '1' : '0';
    EXPECT_TRUE(is_damaged(other)) << other;
  }
  EXPECT_FALSE(is_damaged(R"({"seq":0,"kind":"step","data":{"name":"lift"}})")) << "of an earlier version";
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
