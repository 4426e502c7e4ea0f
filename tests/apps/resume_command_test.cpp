// A run whose process is killed, and that goes on: `stonestack run --resume`.
#include <set>
#include <sstream>

#include "commands.hpp"

namespace stonestack {
namespace {

using ::testing::Not;
using ResumeCommand = Commands;

const std::string kTwoStones = "run --robot ur10 --per-run 2 --seed 3 --set search.horizon=1 --out run";

/// Starts the command and kills it as soon as the journal has a line that holds `line`.
std::string killed_at(const std::string& folder, const std::string& arguments, const std::string& line) {
  return concat("cd ", folder, " && { ", STONESTACK_BINARY, " ", arguments, " 2>err & pid=$!; ",
                "for i in $(seq 6000); do grep -qs '", line,
                "' run/journal.jsonl && break; sleep 0.02; done; ",
                "kill -KILL $pid; wait $pid; echo code $?; } 2>/dev/null");
}

std::vector<json> journal_lines(const std::string& folder) {
  std::vector<json> lines;
  std::istringstream in(read_file(folder + "/run/journal.jsonl", 1 << 24));
  for (std::string line; std::getline(in, line);) lines.push_back(json::parse(line));
  return lines;
}

/// Nothing is lost, nothing doubled, and the tower stands in the true world.
void expect_whole(const std::string& folder) {
  const json result = json::parse(read_file(folder + "/run/result.json", 1 << 24));
  EXPECT_EQ(result.at("height"), 2);
  EXPECT_EQ(result.at("truth").at("height"), 2);
  EXPECT_TRUE(result.at("truth").at("stands").get<bool>());
  std::set<std::string> placed;
  for (const json& placement : result.at("placements")) {
    EXPECT_EQ(placement.at("outcome"), "placed");
    EXPECT_TRUE(placed.insert(placement.at("stone").get<std::string>()).second) << "recorded twice";
  }
  EXPECT_EQ(placed.size(), 2U);
  const auto lines = journal_lines(folder);
  std::size_t outcomes = 0;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    EXPECT_EQ(lines[k].at("seq").get<std::size_t>(), k);
    outcomes += lines[k].at("kind") == "outcome" ? 1 : 0;
  }
  EXPECT_EQ(outcomes, 2U);
}

TEST_F(ResumeCommand, ARunThatIsKilledAgainAndAgainEndsWithItsTower) {
  (void)shell(killed_at(folder_, kTwoStones, "carry "));
  ASSERT_FALSE(fs::exists(folder_ + "/run/result.json")) << "the run was too fast to be killed";
  const Outcome inspected = run("inspect run");
  EXPECT_THAT(inspected.out, HasSubstr("go on with it: stonestack run --resume run"));
  // Killed once more as it takes the stone back.
  (void)shell(killed_at(folder_, "run --resume run", "\"resumed\".*"));
  const Outcome done = run("run --resume run --json");
  ASSERT_EQ(done.code, 0) << done.err;
  expect_whole(folder_);
  EXPECT_THAT(read_file(folder_ + "/run/report.html", 1 << 26), HasSubstr("placed"));
  expect_refusal("run --resume run", 3, {"run: holds a run that ended (all_placed)", "start a new run"});
}

TEST_F(ResumeCommand, AnInterruptedRunSaysHowItGoesOn) {
  const Outcome broken_off = shell(interrupted_at(folder_, kTwoStones, "level 2: "));
  EXPECT_THAT(broken_off.out, HasSubstr("code 130"));
  const std::string last = broken_off.err.substr(broken_off.err.rfind('\n', broken_off.err.size() - 2) + 1);
  EXPECT_THAT(last, HasSubstr("go on with it: stonestack run --resume run\n"));
  EXPECT_THAT(last, HasSubstr("interrupted by the user"));
  EXPECT_THAT(broken_off.out, HasSubstr("report:  run/report.html"));
  EXPECT_TRUE(fs::exists(folder_ + "/run/report.html")) << "a stone stands, whose contacts the report shows";
  EXPECT_TRUE(fs::exists(folder_ + "/run/tower.png"));
  const Outcome done = run("run --resume run");
  ASSERT_EQ(done.code, 0) << done.err;
  expect_whole(folder_);
}

TEST_F(ResumeCommand, OptionsOfARunThatGoesOnCannotBeChanged) {
  expect_refusal("run --resume run --seed 2", 2, {"--seed cannot be changed in a run that goes on"});
  expect_refusal("run --resume none", 3, {"none: is no folder", "give the folder of a run"});
  EXPECT_FALSE(fs::exists(folder_ + "/none"));
}

TEST_F(ResumeCommand, ThePlannersFilesHoldNoTruth) {
  (void)shell(killed_at(folder_, kTwoStones, "lift "));
  const json truth = json::parse(read_file(folder_ + "/run/simulated-cell/world.json", 1 << 26));
  for (const char* file : {"resume.json", "order.json", "journal.jsonl"}) {
    const std::string text = read_file(folder_ + "/run/" + file, 1 << 26);
    for (const json& stone : truth.at("world").at("stones"))
      for (const json& number : stone.at("T_W_O_rest"))
        if (std::abs(number.get<double>()) > 1e-6 && std::abs(number.get<double>()) < 1.0) {
          EXPECT_THAT(text, Not(HasSubstr(number.dump()))) << file;
        }
  }
}

}  // namespace
}  // namespace stonestack
