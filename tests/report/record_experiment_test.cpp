#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/memory.hpp"
#include "resident_memory.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/experiment/option_sources.hpp"
#include "stonestack/report/record_run.hpp"
#include "stonestack/stone/catalogue.hpp"
#include "temporary_folder.hpp"

namespace stonestack::report {
namespace {

/// With a scan error every run makes shapes of its own: two a run beside the six of the catalogue.
TEST(RecordExperiment, HoldsNoMoreMemoryAfterFiveRunsThanAfterTwo) {
  const std::string folder = (std::filesystem::path(test::temporary_folder()) / "memory_of_runs").string();
  std::filesystem::remove_all(folder);
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  ExperimentOrder order;
  order.robot = read_robot("ur10");
  order.stones = 6;
  order.per_run = 2;
  order.survival = false;
  // What a run keeps does not hang on how long it searches.
  set_fields(fields(order.run), {"simulation.scan_error=0.0003", "search.perturbations=0", "search.horizon=1",
                                 "run.measure_friction=false"});
  order.out = folder;
  std::vector<double> after;
  for (const int runs : {2, 5}) {
    order.runs = runs;
    order.continues = runs > 2;
    const RecordedExperiment done = record_experiment(order, catalogue);
    ASSERT_EQ(done.experiment.runs.size(), static_cast<std::size_t>(runs));
    after.push_back(test::resident_megabytes());
    for (const ExperimentRun& run : done.experiment.runs) {
      EXPECT_TRUE(run.report.result.events.empty());
      EXPECT_TRUE(run.report.result.timeline.samples.empty());
    }
  }
  if (test::kSanitizerAllocates) GTEST_SKIP() << "a sanitizer keeps what is freed";
  // Up and down by 14 MB (runs 3 to 13 of seed 1). Sees what a run keeps from 7 MB on; that shapes (1 MB a
  // run) and grasps are not kept for ever is tested where they are kept (shape_store_test, grasp_test).
  EXPECT_LT(after[1], after[0] + 20.0) << "MB after 2 runs: " << after[0] << ", after 5: " << after[1];
  core::return_free_memory();
  EXPECT_GT(test::resident_megabytes(), after[1] - 10.0) << "what was freed has been returned already";
  std::filesystem::remove_all(folder);
}

/// A run as the file has it, without what the host's clock measured.
nlohmann::json without_host_times(nlohmann::json run) {
  for (const char* stage : {"detection", "search", "planning", "beside_motion"}) run["seconds"].erase(stage);
  return run;
}

/// The last run first, as another process may end before one that began earlier.
TEST(RecordExperiment, RunsThatArePerformedElsewhereMakeTheSameRecord) {
  const std::filesystem::path folder = std::filesystem::path(test::temporary_folder()) / "elsewhere";
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  ExperimentOrder order;
  order.robot = read_robot("ur10");
  order.runs = 2;
  order.new_stones = 2;
  order.per_run = 1;
  order.survival = false;
  set_fields(fields(order.run),
             {"simulation.cell=ideal", "search.perturbations=0", "run.measure_friction=false"});
  order.out = folder / "whole";
  ASSERT_TRUE(record_experiment(order, {}).missing.empty());
  const ExperimentOrder alone = order;
  std::vector<int> asked;
  std::size_t performed = 1;
  order.perform_elsewhere = [&](const std::string& record, const std::vector<int>& numbers,
                                const TakeRuns& take) {
    asked = numbers;
    for (std::size_t k = 0; k < performed; ++k) {
      const int number = numbers[numbers.size() - 1 - k];
      EXPECT_NE(
          take({perform_experiment_run(alone, {}, record, number)}).find(concat("run ", number, ": height")),
          std::string::npos);
    }
  };
  order.out = folder / "dealt";
  EXPECT_EQ(record_experiment(order, {}).missing, "1");
  EXPECT_EQ(asked, (std::vector<int>{1, 2}));
  order.continues = true;
  EXPECT_EQ(record_experiment(order, {}).missing, "");
  EXPECT_EQ(asked, std::vector<int>{1});
  const auto file = [&](const char* record) {
    return nlohmann::json::parse(read_file((folder / record / "experiment.json").string(), 1U << 24U));
  };
  const nlohmann::json whole = file("whole"), dealt = file("dealt");
  ASSERT_EQ(dealt["runs"].size(), 2U);
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_EQ(without_host_times(dealt["runs"][k]).dump(), without_host_times(whole["runs"][k]).dump());
  EXPECT_EQ(dealt["heights"], whole["heights"]);
  EXPECT_EQ(dealt["stones"], whole["stones"]);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace stonestack::report
