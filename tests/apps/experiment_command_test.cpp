#include <cmath>

#include "commands.hpp"
#include "stonestack/report/record_run.hpp"

namespace stonestack {
namespace {

/// Numbers to nine digits: a pose that is read and written again may differ in the last.
json without_last_digits(const json& value) {
  if (value.is_number_float()) return std::round(1e9 * value.get<double>());
  if (!value.is_structured()) return value;
  json same = value;
  for (auto& entry : same) entry = without_last_digits(entry);
  return same;
}

TEST_F(Commands, ExperimentKeepsTheRecordOfThePaper) {
  const std::string arguments =
      "experiment --runs 3 --per-run 2 --seed 2 --json --survival false --set search.perturbations=2 --out ";
  const Outcome done = run(arguments + "record");
  ASSERT_EQ(done.code, 0) << done.err;
  const json result = done.data();
  EXPECT_EQ(result["schema"], "stonestack.experiment/1");
  ASSERT_EQ(result["runs"].size(), 3u);
  for (const auto& one : result["runs"]) {
    EXPECT_GE(one["height"], 1) << one["reason"];
    EXPECT_EQ(one["judged_height"], one["height"]) << "a tower is reported that does not stand";
  }
  for (const char* file : {"figure5.svg", "figure5.csv", "runs.csv", "summary.txt", "run-3/tower.png"})
    EXPECT_TRUE(fs::exists(folder_ + "/record/" + file)) << file;
  expect_refusal(arguments + "record", 2, {"record", "is there already"});
  // A run of the experiment is an ordinary run with the seed that its line shows.
  EXPECT_EQ(result["runs"][0]["seed"], 2001);
}

TEST_F(Commands, CtrlCEndsAnExperimentWithWhatWasDoneAndItGoesOn) {
  const Outcome outcome = shell(interrupted_at(
      folder_, "experiment --runs 9 --per-run 1 --seed 7 --survival false --out record", "run 3 of 9"));
  EXPECT_THAT(outcome.out, HasSubstr("code 130")) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("run 3 is not counted"));
  EXPECT_THAT(outcome.out, HasSubstr("towers of 1: 100.0 % (2 of 2;"));
  const json record = json::parse(read_file(folder_ + "/record/experiment.json", 1 << 20), nullptr, false);
  EXPECT_EQ(record["runs"].size(), 2U);

  const std::string again = "experiment --per-run 1 --out record --continue ";
  expect_refusal(again + "--seed 7 --survival false --runs 1", 2, {"record", "holds 2 runs already"});
  expect_refusal(again + "--seed 7 --survival true --runs 3", 2, {"record", "run 1", "--survival false"});
  expect_refusal(again + "--seed 7 --survival false --runs 3 --set search.beam=5", 3,
                 {"run-1/options.yaml", "other options", "beam"});
  expect_refusal("experiment --per-run 2 --out record --continue --seed 7 --survival false --runs 3", 2,
                 {"record", "--per-run 1, not 2"});
  expect_refusal(again + "--survival false --runs 3 --seed 8", 3, {"record", "run 1 has the seed 7001"});
  write("record/run-3/journal.jsonl", "{}");  // as a run leaves it that was stopped under way
  const Outcome goes_on = run(again + "--seed 7 --survival false --runs 3 --json");
  ASSERT_EQ(goes_on.code, 0) << goes_on.err;
  EXPECT_THAT(goes_on.err, testing::Not(HasSubstr("run 1 of 3")));
  EXPECT_TRUE(fs::exists(folder_ + "/record/run-3-interrupted/journal.jsonl"));
  EXPECT_TRUE(fs::exists(folder_ + "/record/run-3/tower.png"));
  ASSERT_EQ(goes_on.data()["runs"].size(), 3U);
  EXPECT_EQ(goes_on.data()["runs"][2]["seed"], 7003);
  for (const char* key : {"seed", "height", "judged_height", "placements", "seconds", "stones", "truth"})
    EXPECT_EQ(without_last_digits(goes_on.data()["runs"][0][key]),
              without_last_digits(record["runs"][0][key]))
        << key;
}

TEST_F(Commands, AVariantWithThePapersDetectionHasAllOfIt) {
  const Outcome done =
      run("experiment --runs 1 --per-run 1 --seed 4 --survival false --out record "
          "--variant 'paper: detection.method=paper, detection.descriptor=iss'");
  ASSERT_EQ(done.code, 0) << done.err;
  const std::string options = read_file(folder_ + "/record/variant-1/run-1/options.yaml", 1 << 20);
  for (const char* value : {"method: paper", "descriptor: iss", "matching: kdtree", "sweep: false"})
    EXPECT_THAT(options, HasSubstr(value));
}

TEST_F(Commands, EveryRunHasNewStonesAndGoesOnWithThem) {
  const std::string arguments =
      "experiment --per-run 1 --new-stones 2 --protocol paper --seed 3 --survival false --json --out record ";
  const Outcome first = run(arguments + "--runs 1");
  ASSERT_EQ(first.code, 0) << first.err;
  const Outcome both = run(arguments + "--runs 2 --continue");
  ASSERT_EQ(both.code, 0) << both.err;
  const json runs = both.data()["runs"];
  ASSERT_EQ(runs.size(), 2U);
  EXPECT_EQ(both.data()["protocol"], "paper");
  EXPECT_EQ(both.data()["new_stones"], 2);
  EXPECT_EQ(both.data()["stone_sets"], 2);
  EXPECT_EQ(without_last_digits(runs[0]["stones"]), first.data()["runs"][0]["stones"]);
  EXPECT_THAT(runs[0]["stones"][0].get<std::string>(), testing::StartsWith("limestone_3001_"));
  EXPECT_THAT(runs[1]["stones"][0].get<std::string>(), testing::StartsWith("limestone_3002_"));
  EXPECT_THAT(read_file(folder_ + "/record/run-2/options.yaml", 1 << 20), HasSubstr("max_failures: 1"));
  expect_refusal(
      "experiment --runs 2 --per-run 1 --new-stones 3 --protocol paper --seed 3 --survival false "
      "--out record --continue",
      2, {"record", "--new-stones 2"});
  expect_refusal(
      "experiment --runs 2 --per-run 1 --new-stones 2 --seed 3 --survival false --out record "
      "--continue",
      2, {"record", "--protocol paper, not full"});
}

/// The host's times are measured: those of `times` in place of the experiment's own.
Experiment with_host_seconds(Experiment experiment, const Experiment& times) {
  for (std::size_t i = 0; i < std::min(experiment.runs.size(), times.runs.size()); ++i) {
    const double motion = experiment.runs[i].report.result.seconds.motion;
    experiment.runs[i].report.result.seconds = times.runs[i].report.result.seconds;
    experiment.runs[i].report.result.seconds.motion = motion;
  }
  return experiment;
}

/// Each run has two of the six stones that none of the others has.
TEST_F(Commands, ShardsMergeIntoTheWholeExperiment) {
  const std::string arguments =
      concat("experiment --runs 3 --per-run 1 --new-stones 2 --new-stones-from ", data_path("stones"),
             " --protocol paper --seed 2 --survival false --set search.perturbations=0",
             " --set run.measure_friction=false --out ");
  for (const char* part : {"whole", "first --shard 1/2", "second --shard 2/2"}) {
    const Outcome done = run(arguments + part);
    ASSERT_EQ(done.code, 0) << done.err;
  }
  EXPECT_FALSE(fs::exists(folder_ + "/first/run-2"));
  EXPECT_TRUE(fs::exists(folder_ + "/first/run-3"));
  const auto expect_whole = [&](const std::string& record) {
    const auto file = [&](const std::string& name) {
      return read_file(folder_ + "/" + record + "/" + name, 1U << 20U);
    };
    const Experiment whole = with_host_seconds(read_experiment(folder_ + "/whole/experiment.json"),
                                               read_experiment(folder_ + "/" + record + "/experiment.json"));
    EXPECT_EQ(without_last_digits(json::parse(file("experiment.json"))),
              without_last_digits(json::parse(experiment_json(whole))));
    EXPECT_EQ(file("runs.csv"), runs_csv(whole));
    EXPECT_EQ(file("summary.txt"), experiment_table(whole));
    EXPECT_EQ(file("figure5.svg"), figure5_svg(whole));
    for (const std::string same : {"figure5.csv", "options.yaml", "run-1/options.yaml", "run-2/options.yaml",
                                   "run-3/options.yaml", "run-3/tower.png"})
      EXPECT_EQ(file(same), read_file(folder_ + "/whole/" + same, 1U << 20U)) << same;
    EXPECT_THAT(file("report.html"), HasSubstr(whole.title));
  };
  const Outcome merged = run("experiment --json --out merged --merge second first");
  ASSERT_EQ(merged.code, 0) << merged.err;
  EXPECT_EQ(merged.data()["runs"].size(), 3U);
  expect_whole("merged");

  const Outcome part = run("experiment --merge first --out part");
  EXPECT_EQ(part.code, 3);
  EXPECT_THAT(part.err, HasSubstr("part: runs are missing: 2; "));
  EXPECT_THAT(part.out, HasSubstr("(2 of 2;"));
  write("part/run-2/journal.jsonl", "{}");  // as a run leaves it that was stopped under way
  const Outcome rest = run(arguments + "part --continue");
  ASSERT_EQ(rest.code, 0) << rest.err;
  EXPECT_THAT(rest.err, testing::Not(HasSubstr("run 3 of 3")));
  EXPECT_TRUE(fs::exists(folder_ + "/part/run-2-interrupted/journal.jsonl"));
  EXPECT_FALSE(fs::exists(folder_ + "/first/run-2"));
  expect_whole("part");

  const Outcome again = run(arguments + "first --shard 1/2 --continue");  // nothing is left to do
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_THAT(again.err, HasSubstr("2 runs are there already"));
  expect_refusal(arguments + "first --shard 2/2 --continue", 2, {"first", "--shard 1/2, not 2/2"});
  expect_refusal(arguments + "first --continue", 2, {"first", "--shard 1/2, not 1/1"});
  expect_refusal("experiment --merge first second --out merged", 2, {"merged", "is there already"});
  expect_refusal("experiment --merge first second --runs 3 --out more", 2, {"--merge", "--runs"});
  expect_refusal("experiment --merge first first --out more", 3, {"first: run 1 is in first, too"});
  EXPECT_FALSE(fs::exists(folder_ + "/more"));
}

/// An impossible experiment is refused before anything is built, not after the rows before it.
TEST_F(Commands, AnExperimentThatCannotBeDoneIsNotBegun) {
  const std::string arguments = "experiment --runs 1 --per-run 1 --survival false --out record ";
  expect_refusal(arguments + "--variant 'as it is:' --variant 'odd: search.no_such_thing=3'", 2,
                 {"search.no_such_thing"});
  expect_refusal(arguments + "--set simulation.seed=7", 2, {"1000 S + k", "7"});
  expect_refusal(arguments + "--variant 'odd: search.seed=9'", 2, {"1000 S + k", "9"});
  expect_refusal(arguments + "--seed 2147483647", 2, {"2147483647", "2147483"});
  expect_refusal("experiment --runs 1 --per-run 7 --out record", 2, {"--per-run 7 of 6 stones", "--stones"});
  expect_refusal("experiment --runs 1 --per-run 3 --new-stones 2 --out record", 2, {"--new-stones 2"});
  expect_refusal("experiment --runs 1 --new-stones-from rocks --out record", 2, {"--new-stones-from rocks"});
  expect_refusal("experiment --runs 1 --new-stones 4 --new-stones-from rocks --out record", 3, {"rocks"});
  expect_refusal("experiment --runs 1 --new-stones 4 --catalogue rocks --out record", 2, {"--catalogue"});
  expect_refusal("experiment --runs 1 --new-stones 4 --stones 6 --out record", 2, {"--stones"});
  expect_refusal("experiment --runs 1 --protocol short --out record", 2, {"--protocol"});
  for (const std::string shard : {"0/3", "4/3", "2", "a/b"})
    expect_refusal(arguments + "--shard " + shard, 2, {"--shard", "'" + shard + "'"});
  expect_refusal(arguments + "--shard 2/2", 2, {"--shard 2/2 of --runs 1"});
  expect_refusal(arguments + "--shard 1/2 --variant 'as it is:'", 2, {"--shard 1/2", "comparison"});
  EXPECT_FALSE(fs::exists(folder_ + "/record"));
}

/// Also where its first run was stopped, so that no run shows what it was.
TEST_F(Commands, AnExperimentWithoutARunGoesOnWithAsManyStonesARun) {
  const Outcome stopped = shell(
      interrupted_at(folder_, "experiment --runs 2 --per-run 2 --survival false --out record", "run 1 of 2"));
  EXPECT_THAT(stopped.out, HasSubstr("code 130")) << stopped.err;
  expect_refusal("experiment --runs 2 --per-run 3 --survival false --out record --continue", 2,
                 {"record", "--per-run 2, not 3"});
}

TEST_F(Commands, OneExperimentAtATimeWritesIntoAFolder) {
  fs::create_directories(folder_ + "/record");
  const Outcome second = shell(concat("cd ", folder_, " && flock record ", STONESTACK_BINARY,
                                      " experiment --runs 1 --continue --out record 2>err"));
  EXPECT_EQ(second.code, 3);
  EXPECT_THAT(second.err, HasSubstr("record: another program is writing its record there"));
}

TEST_F(Commands, ExperimentGoesOnOnlyWithAFolderThatItCanRead) {
  expect_refusal("experiment --continue", 2, {"--continue", "--out"});
  write("record/experiment.json", "{\"schema\": \"stonestack.experiment/1\", \"title\": 7}");
  expect_refusal("experiment --continue --out record", 3, {"record/experiment.json", "title"});
  write("record/experiment.json", "{\"schema\": ");
  expect_refusal("experiment --continue --out record", 3, {"record/experiment.json", "not JSON"});
}

}  // namespace
}  // namespace stonestack
