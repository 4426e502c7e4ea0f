#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "rooms.hpp"
#include "stacking/journal.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/stacking/scene_tasks.hpp"
#include "temporary_folder.hpp"

namespace stonestack::stacking {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::string kPose =
    R"("T_W_O": {"x": 0.7, "y": 0.28, "z": 0.0381, "qx": 0, "qy": 0, "qz": 0, "qw": 1})";

/// A journal up to the carrying of a second stone.
std::string killed_run(const std::string& name) {
  const std::string folder = test::temporary_folder() + name;
  Journal journal(folder + "/journal.jsonl");
  journal.record("observed", R"({"stack": [{"stone": "a"}], "loose": [{"stone": "b"}, {"stone": "c"}]})");
  journal.record("target", R"({"stone": "b", "cost": 0.2, )" + kPose + "}");
  journal.record("step", R"({"name": "lift b"})");
  journal.record("hold", R"({"weight": 10.04, "expected": 11, "off": 0.0021})");
  journal.record("step", R"({"name": "carry b above its place"})");
  return folder;
}

TEST(InspectRun, SaysWhatHappenedAndWhereAKilledRunWas) {
  const std::string folder = killed_run("killed");
  const RunInspection found = inspect_run(folder);
  EXPECT_FALSE(found.whole);
  EXPECT_THAT(found.text, HasSubstr("stack: a; loose: b, c\nplace b at (700 mm, 280 mm, 38 mm)\n  lift b\n"
                                    "    holds 10 N of 11 N, 2 mm beside the planned point\n"));
  EXPECT_THAT(found.text, HasSubstr("not ended by the program, the last step that began: carry b"));
  const auto j = nlohmann::json::parse(found.json);
  EXPECT_EQ(j.at("last_step"), "carry b above its place");
  EXPECT_TRUE(j.at("end").is_null());
  EXPECT_EQ(j.at("loose").size(), 2U);

  Journal again(folder + "/journal.jsonl");
  again.record("outcome", R"({"stone": "b", "outcome": "placed"})");
  again.record("end", R"({"end": "all_placed", "reason": "all stones that are seen are placed"})");
  const RunInspection ended = inspect_run(folder);
  EXPECT_TRUE(ended.whole) << ended.text;
  EXPECT_THAT(ended.text, HasSubstr("b: placed\nend (all_placed): all stones"));
}

TEST(InspectRun, SaysHowARunGoesOn) {
  const std::string folder = killed_run("resumable");
  EXPECT_THAT(inspect_run(folder).text, Not(HasSubstr("--resume"))) << "nothing was kept for it";
  write_file(folder + "/resume.json", "{}");
  EXPECT_THAT(inspect_run(folder).text, HasSubstr("go on with it: stonestack run --resume " + folder + "\n"));
  EXPECT_EQ(nlohmann::json::parse(inspect_run(folder).json).at("resumable"), true);
  Journal journal(folder + "/journal.jsonl");
  journal.record("outcome", R"({"stone": "b", "outcome": "lost"})");
  journal.record("end", R"({"end": "stopped", "reason": "the arm stopped"})");
  EXPECT_THAT(inspect_run(folder).text, HasSubstr("--resume"));
  journal.record("resumed", R"({"placements": 0, "attempt": "place"})");
  const RunInspection again = inspect_run(folder);
  EXPECT_THAT(again.text, HasSubstr("resumed after 0 placements, in the midst of: place\n"));
  EXPECT_TRUE(nlohmann::json::parse(again.json).at("outcomes").empty()) << "it is judged again";
  EXPECT_FALSE(again.whole) << "the run is under way again";
  journal.record("end", R"({"end": "all_placed", "reason": "all placed"})");
  EXPECT_THAT(inspect_run(folder).text, Not(HasSubstr("--resume")));
}

TEST(InspectRun, NamesLinesThatAreNotAsTheyWereWritten) {
  const std::string folder = killed_run("damaged"), path = folder + "/journal.jsonl";
  const std::string whole = read_file(path, 1 << 20);
  const auto damaged = [&](const std::string& content) {
    write_file(path, content);
    const RunInspection found = inspect_run(folder);
    EXPECT_FALSE(found.whole);
    return found.text;
  };
  EXPECT_THAT(damaged(whole.substr(0, whole.size() - 5)), HasSubstr("the last line was cut off"));
  const std::size_t second = whole.find('\n') + 1;
  EXPECT_THAT(damaged(whole.substr(second)), HasSubstr("line 1 has the sequence number 1"));
  std::string forged = whole;
  forged.replace(forged.find("10.04"), 5, "10.94");
  EXPECT_THAT(damaged(forged), HasSubstr("line 4 is not as it was written"));
  std::string other = whole;
  other[second] = '[';
  EXPECT_THAT(damaged(other), HasSubstr("line 2 is no line of a journal"));
  EXPECT_THAT(damaged("\n" + std::string(1, '\0') + "\n[]\n{\"seq\": 3, \"kind\": 4}\n"),
              HasSubstr("line 4 is no line of a journal"));
  try {
    (void)inspect_run(folder + "/none");
    FAIL() << "a folder without a journal";
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("none/journal.jsonl: is not there"));
  }
}

}  // namespace
}  // namespace stonestack::stacking
