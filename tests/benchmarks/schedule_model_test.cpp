#include "benchmarks/schedule_model.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/report/record_run.hpp"
#include "temporary_folder.hpp"

namespace stonestack::bench {
namespace {

const std::vector<double> kRuns{8.0, 1.0, 1.0, 1.0, 1.0, 4.0};

TEST(Schedule, DealtRunsGoToTheRankThatIsFree) {
  EXPECT_DOUBLE_EQ(dynamic_makespan(kRuns, 1, 0.0), 16.0);
  EXPECT_DOUBLE_EQ(dynamic_makespan(kRuns, 2, 0.0), 8.0);
  EXPECT_DOUBLE_EQ(efficiency(kRuns, 2, 8.0), 1.0);
  EXPECT_DOUBLE_EQ(dynamic_makespan(kRuns, 100, 0.0), 8.0);
  EXPECT_DOUBLE_EQ(dynamic_makespan(kRuns, 1, 0.5), 19.0);
}

TEST(Schedule, DividedRunsWaitForTheirRank) {
  EXPECT_DOUBLE_EQ(static_makespan(kRuns, 1), 16.0);
  EXPECT_DOUBLE_EQ(static_makespan(kRuns, 2), 10.0);  // 8 + 1 + 1 beside 1 + 1 + 4
  EXPECT_DOUBLE_EQ(static_makespan(kRuns, 6), 8.0);
}

TEST(Schedule, TheTimeOfARunIsThatOfItsFiles) {
  namespace fs = std::filesystem;
  const std::string folder = test::temporary_folder() + "recorded";
  Experiment experiment;
  experiment.total = 1;
  experiment.runs.resize(1);
  experiment.runs[0].number = 1;
  experiment.runs[0].report.result.seconds.detection = 3.0;
  write_file(folder + "/experiment.json", report::experiment_json(experiment));
  EXPECT_THROW((void)recorded_run_times(folder), FileError) << "no run of that number";
  for (const char* name : {"/run-1/options.yaml", "/run-1/report.html"}) write_file(folder + name, "");
  const auto began = fs::last_write_time(folder + "/run-1/options.yaml");
  fs::last_write_time(folder + "/run-1/report.html", began + std::chrono::seconds(20));
  EXPECT_NEAR(recorded_run_times(folder).at(0), 20.0, 1e-3);
  fs::last_write_time(folder + "/run-1/report.html", began + std::chrono::seconds(2));
  EXPECT_THROW((void)recorded_run_times(folder), FileError) << "a copy";
}

}  // namespace
}  // namespace stonestack::bench
