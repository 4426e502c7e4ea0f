// Efficiency of experiments on many ranks, simulated from the times of recorded runs: runs that are dealt one
// by one (stonestack-mpi) beside runs that are divided beforehand (shards).
#include "soak.hpp"

#include <algorithm>
#include <memory>

#include "core/quantile.hpp"
#include "schedule_model.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::bench {
namespace {

struct ScheduleOptions {
  std::string record;
  std::vector<int> ranks{1, 2, 10, 100, 1000};
  int runs_a_rank = 20;
  double delay_ms = 10.0;
  int seed = 1;
};

std::vector<double> drawn(const std::vector<double>& recorded, std::size_t count, int seed) {
  Random random = Random::stream(static_cast<std::uint64_t>(seed), "times of runs");
  std::vector<double> times(count);
  for (double& time : times) time = recorded[random.index(recorded.size())];
  return times;
}

void measure_schedules(const ScheduleOptions& options, Results& results) {
  const std::vector<double> recorded = recorded_run_times(options.record);
  results.settings({{"recorded_runs", recorded.size()},
                    {"shortest_s", quantile(recorded, 0.0)},
                    {"median_s", quantile(recorded, 0.5)},
                    {"longest_s", quantile(recorded, 1.0)},
                    {"runs_a_rank", options.runs_a_rank},
                    {"delay_ms", options.delay_ms},
                    {"seed", options.seed}});
  results.table("schedules", {{"ranks"},
                              {"runs"},
                              {"dealt_hours", 2},
                              {"dealt_efficiency", 3},
                              {"divided_hours", 2},
                              {"divided_efficiency", 3}});
  for (const int ranks : options.ranks) {
    const auto count = static_cast<std::size_t>(ranks) * static_cast<std::size_t>(options.runs_a_rank);
    const std::vector<double> runs = drawn(recorded, count, options.seed);
    const double dealt = dynamic_makespan(runs, ranks, 1e-3 * options.delay_ms);
    const double divided = static_makespan(runs, ranks);
    results.row({ranks, count, dealt / 3600, efficiency(runs, ranks, dealt), divided / 3600,
                 efficiency(runs, ranks, divided)});
  }
}

}  // namespace

void add_schedule(CLI::App& app) {
  auto options = std::make_shared<ScheduleOptions>();
  CLI::App* sub = app.add_subcommand(
      "schedule", "Efficiency of experiments on many ranks, simulated from the times of recorded runs");
  sub->add_option("--experiment", options->record, "Folder of the recorded experiment")
      ->required()
      ->type_name("DIR");
  sub->add_option("--ranks", options->ranks, "Processes")
      ->delimiter(',')
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  sub->add_option("--runs-a-rank", options->runs_a_rank, "Runs of the experiment for each process")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  sub->add_option("--delay", options->delay_ms, "Time that a process waits for a run, ms")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  sub->add_option("--seed", options->seed)->check(CLI::Range(0, 2147483647))->capture_default_str();
  sub->footer(
      "Times are drawn from the recorded ones, with replacement.\n"
      "Example:\n"
      "  stonestack-bench schedule --experiment long --ranks 1,2,10,100,1000");
  measure_by(*sub, [options](Results& results) { measure_schedules(*options, results); });
}

}  // namespace stonestack::bench
