#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <vector>

#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/report/record_run.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack::report {
namespace {

/// Resident memory of this process [MB].
double resident_megabytes() {
  std::ifstream statm("/proc/self/statm");
  long total = 0, resident = 0;
  statm >> total >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

/// With a scan error every run makes shapes of its own: two a run beside the six of the catalogue, so that
/// the twelve that the library keeps are there after the third run. What grows later grows for ever.
TEST(RecordExperiment, HoldsNoMoreMemoryAfterEightRunsThanAfterThree) {
  const std::string folder = (std::filesystem::path(testing::TempDir()) / "memory_of_runs").string();
  std::filesystem::remove_all(folder);
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  ExperimentOrder order;
  order.robot = read_robot("ur10");
  order.stones = 6;
  order.per_run = 2;
  order.survival = false;
  order.run.simulation.scan_error = 0.0003;
  order.out = folder;
  std::vector<double> after;
  for (const int runs : {3, 8}) {
    order.runs = runs;
    order.continues = runs > 3;
    const RecordedExperiment done = record_experiment(order, catalogue);
    ASSERT_EQ(done.experiment.runs.size(), static_cast<std::size_t>(runs));
    after.push_back(resident_megabytes());
    for (const ExperimentRun& run : done.experiment.runs) {
      EXPECT_TRUE(run.report.result.events.empty());
      EXPECT_TRUE(run.report.result.timeline.samples.empty());
    }
  }
  // Without returning what is freed 17 MB were measured, with it 4 to 12, at most 8 after 9 more runs.
  EXPECT_LT(after[1], after[0] + 15.0) << "MB after 3 runs: " << after[0] << ", after 8: " << after[1];
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace stonestack::report
