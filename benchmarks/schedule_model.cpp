#include "schedule_model.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <numeric>
#include <queue>

#include "stonestack/core/error.hpp"
#include "stonestack/report/record_run.hpp"

namespace stonestack::bench {
namespace {

namespace fs = std::filesystem;

double sum_of(const std::vector<double>& runs) {
  return std::accumulate(runs.begin(), runs.end(), 0.0);
}

/// A run writes its options first and its report last.
double time_of_run(const std::string& folder) {
  std::error_code problem;
  const auto first = fs::last_write_time(folder + "/options.yaml", problem);
  const auto last = problem ? first : fs::last_write_time(folder + "/report.html", problem);
  if (problem) throw FileError(folder, "no record of a run that ended", "name the folder of an experiment");
  return std::chrono::duration<double>(last - first).count();
}

}  // namespace

double dynamic_makespan(const std::vector<double>& runs, int ranks, double delay) {
  std::priority_queue<double, std::vector<double>, std::greater<>> free_at;
  for (int rank = 0; rank < ranks; ++rank) free_at.push(0.0);
  double last = 0.0;
  for (const double run : runs) {
    const double end = free_at.top() + delay + run;
    free_at.pop();
    free_at.push(end);
    last = std::max(last, end);
  }
  return last;
}

double static_makespan(const std::vector<double>& runs, int ranks) {
  std::vector<double> busy(static_cast<std::size_t>(ranks), 0.0);
  for (std::size_t k = 0; k < runs.size(); ++k) busy[k % busy.size()] += runs[k];
  return *std::max_element(busy.begin(), busy.end());
}

double efficiency(const std::vector<double>& runs, int ranks, double makespan) {
  return sum_of(runs) / (ranks * makespan);
}

std::vector<double> recorded_run_times(const std::string& folder) {
  std::vector<double> times;
  for (const ExperimentRun& run : report::read_experiment(folder + "/experiment.json").runs) {
    const std::string place = concat(folder, "/run-", run.number);
    const StageSeconds& known = run.report.result.seconds;
    times.push_back(time_of_run(place));
    if (times.back() < known.detection)
      throw FileError(
          place,
          concat("its files span ", times.back(), " s, but detection took ", known.detection, " s: a copy"),
          "name the folder in which the runs were made");
  }
  if (times.empty()) throw FileError(folder, "no run has ended", "name the folder of an experiment");
  return times;
}

}  // namespace stonestack::bench
