// The folder into which `run` writes: who has it, what is in it when something goes wrong.
#include "commands.hpp"

namespace stonestack {
namespace {

using ::testing::Not;
using RunRecord = Commands;

const std::string kSmallRun = "run --per-run 1 --height 1 --seed 1 ";

TEST_F(RunRecord, ExecuteWithoutACellIsRefused) {
  expect_refusal("run --execute", 2, {"--execute", "--cell"});
  EXPECT_FALSE(fs::exists(folder_ + "/runs"));
}

TEST_F(RunRecord, MoreStonesThanThereAreAreRefused) {
  expect_refusal("run --per-run 9", 2, {"--per-run 9", "has 6 stones"});
  EXPECT_FALSE(fs::exists(folder_ + "/runs"));
}

TEST_F(RunRecord, OptionsThatExcludeEachOtherAreRefusedBeforeAnythingIsWritten) {
  expect_refusal("run --wall 4+x", 2, {"4+x", "is not a number"});
  expect_refusal("run --wall 2+1 --method paper", 2, {"a wall needs the default search"});
  expect_refusal("run --wall 2+1 --objective firm", 2, {"objective firm is for towers"});
  expect_refusal("run --method paper --objective firm", 2, {"objective firm needs the default search"});
  EXPECT_FALSE(fs::exists(folder_ + "/runs"));
}

TEST_F(RunRecord, OneRunAtATimeWritesIntoAFolder) {
  fs::create_directories(folder_ + "/taken");
  const Outcome second = shell(
      concat("cd ", folder_, " && flock taken ", STONESTACK_BINARY, " ", kSmallRun, "--out taken 2>err"));
  EXPECT_EQ(second.code, 3);
  EXPECT_THAT(second.err, HasSubstr("taken: another program is writing its record there"));
  EXPECT_TRUE(fs::is_empty(folder_ + "/taken"));
}

TEST_F(RunRecord, RunsOfTheSameSecondAndSeedHaveAFolderEach) {
  const Outcome both = shell(concat("cd ", folder_, " && { ", STONESTACK_BINARY, " ", kSmallRun,
                                    ">out 2>err & ", STONESTACK_BINARY, " ", kSmallRun,
                                    ">out2 2>err2; first=$?; wait $!; ", "echo $first $?; }"));
  EXPECT_EQ(both.out, "0 0\n") << both.err;
  int whole = 0;
  for (const auto& folder : fs::directory_iterator(folder_ + "/runs"))
    whole += fs::exists(folder.path() / "result.json") ? 1 : 0;
  EXPECT_EQ(whole, 2);
}

TEST_F(RunRecord, AFolderThatCannotBeIsRefusedAtOnceAndForItsReason) {
  write("file", "no folder");
  expect_refusal(kSmallRun + "--out file", 3, {"file: ", "Not a directory", "--out"});
  expect_refusal(kSmallRun + "--out /sys/stonestack_test/run", 3,
                 {"/sys/stonestack_test/run: the folder /sys/stonestack_test cannot be made"});
  EXPECT_THAT(run(kSmallRun + "--out /sys/stonestack_test/run").err, Not(HasSubstr("simulated cell")));
}

TEST_F(RunRecord, ARunThatWasKilledIsStartedAgainByTheSameCommand) {
  write("run/options.yaml", "left: behind\n");
  write("run/journal.jsonl", "");
  const Outcome done = run(kSmallRun + "--out run");
  EXPECT_EQ(done.code, 0) << "an empty journal holds no run: " << done.err;
  EXPECT_THAT(read_file(folder_ + "/run/journal.jsonl", 1 << 20), HasSubstr("\"seq\":0"));
  EXPECT_FALSE(fs::exists(folder_ + "/run-interrupted")) << "there was nothing to keep";
  // Killed later: there is a journal, and no result.
  fs::remove(folder_ + "/run/result.json");
  const Outcome again = run(kSmallRun + "--out run");
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_THAT(again.err, HasSubstr("run holds a run that did not end; it is kept as run-interrupted"));
  EXPECT_TRUE(fs::exists(folder_ + "/run-interrupted/journal.jsonl"));
  EXPECT_TRUE(fs::exists(folder_ + "/run/result.json"));
  expect_refusal(kSmallRun + "--out run", 2, {"holds a run already"});
}

/// Files that may not grow beyond 400 blocks of 512 bytes, which is more than a run needs and less than its
/// picture, stand for a disk that is full when picture and report come.
TEST_F(RunRecord, AFullDiskCostsPictureAndReportAndNothingElse) {
  const Outcome full = shell(concat("cd ", folder_, " && ulimit -f 400 && ", STONESTACK_BINARY, " ",
                                    kSmallRun, "--json --out run 2>err"));
  EXPECT_EQ(full.code, 3) << full.err;
  EXPECT_THAT(full.err, HasSubstr("run/tower.png: cannot be written: File too large"));
  EXPECT_THAT(full.err, HasSubstr("tower of 1 of 1 stones")) << "the table is missing";
  const json result = json::parse(read_file(folder_ + "/run/result.json", 1 << 20), nullptr, false);
  EXPECT_EQ(result["height"], 1);
  EXPECT_TRUE(result.contains("truth"));
  EXPECT_FALSE(result.contains("picture")) << "it names a file that is not there";
  EXPECT_EQ(full.data(), result);
  EXPECT_FALSE(fs::exists(folder_ + "/run/report.html"));
  EXPECT_FALSE(fs::exists(folder_ + "/run/tower.png"));
  for (const auto& file : fs::directory_iterator(folder_ + "/run"))
    EXPECT_THAT(file.path().filename().string(), Not(HasSubstr(".part"))) << "left behind";
}

/// The arm does not go on without a journal, and what was done so far is reported.
TEST_F(RunRecord, AFullDiskDuringTheRunStopsItAndTheTableIsPrinted) {
  fs::create_directories(folder_ + "/run");
  fs::create_symlink("/dev/full", folder_ + "/run/journal.jsonl");
  const Outcome stopped = run(kSmallRun + "--out run");
  EXPECT_EQ(stopped.code, 7) << stopped.err;
  EXPECT_THAT(stopped.out,
              HasSubstr("tower of 0 of 1 stones; ended: run/journal.jsonl: cannot be written: No space"));
  EXPECT_TRUE(fs::exists(folder_ + "/run/result.json"));
}

/// Whoever reads messages or the table may end; the arm is not left in the midst of a motion for that.
TEST_F(RunRecord, ARunIsCompletedWhenNobodyReadsItAnyMore) {
  const auto code_of = [&](const std::string& command, const std::string& reader) {
    (void)shell(concat("cd ", folder_, " && : >err; { sleep 0.5; ", STONESTACK_BINARY, ' ', command,
                       "; echo $? >code; } ", reader));
    return read_file(folder_ + "/code", 100);
  };
  EXPECT_EQ(code_of(kSmallRun + "--out run >table", "2>&1 | true"), "0\n");
  EXPECT_TRUE(fs::exists(folder_ + "/run/report.html"));
  EXPECT_THAT(read_file(folder_ + "/table", 10000), HasSubstr("tower of 1 of 1 stones"));
  EXPECT_EQ(code_of("help run 2>err", "| true"), "141\n") << "by SIGPIPE, as shells expect";
  EXPECT_EQ(read_file(folder_ + "/err", 1000), "");
}

TEST_F(RunRecord, ARunThatFailsAtItsStartNamesNoRecord) {
  write("lab.yaml",
        "arm: {address: 127.0.0.1, rtde_port: 1, primary_port: 1, secondary_port: 1, realtime_port: 1, "
        "dashboard_port: 1}\n");
  const Outcome failed = run("run --cell lab.yaml --execute --out run");
  EXPECT_EQ(failed.code, 6) << failed.err;
  EXPECT_THAT(failed.err, Not(HasSubstr("record")));
  EXPECT_FALSE(fs::exists(folder_ + "/run")) << "an empty folder was left behind";
}

}  // namespace
}  // namespace stonestack
