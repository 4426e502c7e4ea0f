#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/report/record_run.hpp"
#include "temporary_folder.hpp"

namespace stonestack::report {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

/// Shards of an experiment of five runs, written as `record_experiment` writes them.
class MergeExperiments : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = test::temporary_folder() + "merge_" +
              testing::UnitTest::GetInstance()->current_test_info()->name() + "/";
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  static Experiment shard(Shard part, const std::vector<int>& runs) {
    Experiment experiment;
    experiment.title = "5 runs of 2 of 3 stones, ur10, seed 7";
    experiment.seed = 7;
    experiment.total = 5;
    experiment.shard = part;
    experiment.stones = {"a", "b", "c"};
    experiment.per_run = 2;
    for (const int number : runs) {
      ExperimentRun run;
      run.number = number;
      run.report.seed = 7000 + number;
      run.report.version = "1.0";
      run.report.present = {"a", "b"};
      run.report.result.height = number % 3;
      run.report.result.seconds.motion = 0.1 * number;
      experiment.runs.push_back(run);
    }
    return experiment;
  }
  /// @return the folder's path
  std::string write(const std::string& name, const Experiment& experiment,
                    const std::string& options = "seed: 7\nsearch:\n  beam: 4\n") const {
    const std::string folder = folder_ + name;
    write_file(folder + "/experiment.json", experiment_json(experiment));
    write_file(folder + "/options.yaml", options);
    for (const ExperimentRun& run : experiment.runs)
      write_file(concat(folder, "/run-", run.number, "/result.json"), run_json(run.report));
    return folder;
  }
  [[nodiscard]] std::string text(const std::string& name) const {
    return read_file(folder_ + name, 1U << 20U);
  }
  [[nodiscard]] RecordedExperiment merge(const std::vector<std::string>& folders) const {
    return merge_experiments(folders, folder_ + "out");
  }
  /// The merge fails before it makes its folder, with a message that holds all of `parts`.
  void expect_refusal(const std::vector<std::string>& folders, const std::vector<std::string>& parts) const {
    try {
      (void)merge(folders);
      ADD_FAILURE() << "merged; expected " << parts.front();
    } catch (const Error& error) {
      for (const std::string& part : parts) EXPECT_THAT(error.what(), HasSubstr(part));
    }
    EXPECT_FALSE(fs::exists(folder_ + "out"));
  }

  std::string folder_;
};

TEST_F(MergeExperiments, GivesTheRecordOfTheWholeExperiment) {
  const Experiment whole = shard({}, {1, 2, 3, 4, 5});
  const RecordedExperiment done =
      merge({write("second", shard({2, 2}, {2, 4})), write("first", shard({1, 2}, {1, 3, 5}))});
  EXPECT_EQ(done.folder, folder_ + "out");
  EXPECT_EQ(done.missing, "");
  EXPECT_EQ(text("out/experiment.json"), experiment_json(whole));
  EXPECT_EQ(text("out/runs.csv"), runs_csv(whole));
  EXPECT_EQ(text("out/figure5.csv"), figure5_csv(whole));
  EXPECT_EQ(text("out/figure5.svg"), figure5_svg(whole));
  EXPECT_EQ(text("out/summary.txt"), experiment_table(whole));
  EXPECT_EQ(text("out/options.yaml"), text("first/options.yaml"));
  EXPECT_TRUE(fs::exists(folder_ + "out/report.html"));
  for (int k = 1; k <= 5; ++k)
    EXPECT_EQ(json::parse(text(concat("out/run-", k, "/result.json")))["seed"], 7000 + k);
  EXPECT_THAT(experiment_table(shard({2, 2}, {2, 4})), HasSubstr(", shard 2/2 (2 done)\n"));
}

/// Also parts that the reader of experiments omits, as the modelling of stones that nobody scanned.
TEST_F(MergeExperiments, KeepsAllOfARun) {
  const std::string first = write("first", shard({1, 2}, {1, 3, 5}));
  json content = json::parse(text("first/experiment.json"));
  content["runs"][1]["modelling"] = {{"views", 12}, {"robot_seconds", 0.1 + 0.2}};
  write_file(first + "/experiment.json", content.dump(2));
  (void)merge({first, write("second", shard({2, 2}, {2, 4}))});
  content["runs"][1]["modelling"]["catalogue"] = folder_ + "out/run-3/stones";
  EXPECT_EQ(json::parse(text("out/experiment.json"))["runs"][2], content["runs"][1]);
}

TEST_F(MergeExperiments, ListsWhatIsMissingAndTakesItLater) {
  const std::string first = write("first", shard({1, 4}, {1})), third = write("third", shard({3, 4}, {3}));
  EXPECT_EQ(merge({third, first}).missing, "2, 4, 5");
  EXPECT_EQ(merge_experiments({first}, folder_ + "less").missing, "2 to 5");
  fs::rename(folder_ + "out", folder_ + "part");
  const RecordedExperiment more =
      merge({folder_ + "part", write("second", shard({2, 4}, {2})), write("fourth", shard({4, 4}, {}))});
  EXPECT_EQ(more.missing, "4, 5");
  ASSERT_EQ(more.experiment.runs.size(), 3U);
  EXPECT_EQ(more.experiment.runs[1].number, 2);
  EXPECT_THAT(text("out/runs.csv"), HasSubstr("\n3,7003,"));
  EXPECT_THAT(text("out/summary.txt"), HasSubstr("seed 7 (3 done)\n"));
}

TEST_F(MergeExperiments, RefusesShardsOfDifferentExperiments) {
  const std::string first = write("first", shard({1, 2}, {1, 3, 5}));
  const auto differs = [&](const std::function<void(Experiment&)>& change,
                           const std::vector<std::string>& parts) {
    Experiment other = shard({2, 2}, {2, 4});
    change(other);
    fs::remove_all(folder_ + "other");
    std::vector<std::string> all = parts;
    all.insert(all.end(), {folder_ + "other", folder_ + "first"});
    expect_refusal({first, write("other", other)}, all);
  };
  differs([](Experiment& e) { e.seed = 8; }, {"--seed 8", "has 7"});
  differs([](Experiment& e) { e.total = 6; }, {"--runs 6", "has 5"});
  differs([](Experiment& e) { e.per_run = 3; }, {"--per-run 3", "has 2"});
  differs([](Experiment& e) { e.protocol = "paper"; }, {"--protocol paper", "has full"});
  differs([](Experiment& e) { e.new_stones = 4; }, {"--new-stones 4", "has 0"});
  differs([](Experiment& e) { e.new_stones_from = "rocks"; }, {"--new-stones-from rocks"});
  differs([](Experiment& e) { e.stones = {"a", "b", "d"}; }, {"stones a, b, d", "has a, b, c"});
  differs([](Experiment& e) { e.title = "with another arm"; }, {"with another arm", "ur10"});
  differs([](Experiment& e) { e.runs[1].report.version = "1.1"; }, {"run 4 of the version 1.1", "has 1.0"});
  differs([](Experiment& e) { e.runs[0].survival.standing = {1}; }, {"run 2 with --survival true"});
  fs::remove_all(folder_ + "other");
  expect_refusal({first, write("other", shard({2, 2}, {2, 4}), "seed: 7\nsearch:\n  beam: 5\n")},
                 {folder_ + "other", "beam: 5", folder_ + "first", "beam: 4"});
}

TEST_F(MergeExperiments, RefusesRunsThatAreNoPartOfTheExperiment) {
  const std::string first = write("first", shard({1, 2}, {1, 3, 5}));
  expect_refusal({first, write("again", shard({3, 4}, {3}))}, {"again: run 3 is in", "first, too"});
  Experiment odd = shard({2, 2}, {2});
  odd.runs[0].report.seed = 9002;
  expect_refusal({first, write("odd", odd)}, {"odd: run 2 has the seed 9002, not 7002"});
  expect_refusal({first, write("far", shard({6, 6}, {6}))}, {"far: run 6 is not one of 5 runs"});
  const std::string lost = write("lost", shard({2, 2}, {2, 4}));
  fs::remove_all(lost + "/run-4");
  expect_refusal({first, lost}, {"lost: run 4 has no folder"});
  expect_refusal({first, folder_ + "nothing"}, {"nothing/experiment.json"});
  Experiment stray = shard({2, 2}, {2, 3});
  expect_refusal({write("stray", stray)}, {"stray/experiment.json: run 3 is after run 2 of shard 2/2"});
  Experiment old = shard({}, {2});
  old.total = 0;
  expect_refusal({write("old", old)}, {"old/experiment.json", "older version"});
  expect_refusal({}, {"at least one"});
}

TEST_F(MergeExperiments, WritesIntoANewFolderOutsideTheShards) {
  const std::string first = write("first", shard({1, 1}, {1, 2, 3, 4, 5}));
  const auto refusal = [&](const std::string& out) {
    try {
      (void)merge_experiments({first}, out);
    } catch (const InvalidArgument& error) {
      return std::string(error.what());
    }
    return std::string("merged");
  };
  EXPECT_THAT(refusal(first + "/whole"), HasSubstr("is in the shard"));
  EXPECT_FALSE(fs::exists(first + "/whole"));
  fs::create_directories(folder_ + "out");
  EXPECT_THAT(refusal(folder_ + "out"), HasSubstr("is there already"));
  EXPECT_TRUE(fs::is_empty(folder_ + "out"));
}

}  // namespace
}  // namespace stonestack::report
