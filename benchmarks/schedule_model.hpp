#pragma once
#include <string>
#include <vector>

#include "rooms.hpp"

/// How long an experiment takes on many ranks: a model of the schedules of stonestack-mpi and of shards.
namespace stonestack::bench {

/// Time until the last of `runs` (times [s], in the order in which they are dealt) has ended, if each goes to
/// the rank that is free first (list scheduling, Graham 1969). `delay` [s] is what a rank waits for each run.
[[nodiscard]] double dynamic_makespan(const std::vector<double>& runs, int ranks, double delay);
/// Time until the last run has ended if run k belongs to rank k mod `ranks`, as in shards.
[[nodiscard]] double static_makespan(const std::vector<double>& runs, int ranks);
/// Share of the ranks' time that is spent in runs.
[[nodiscard]] double efficiency(const std::vector<double>& runs, int ranks, double makespan);

/// Times [s] of the runs of a recorded experiment, from the first file of each run's folder to the last.
/// Throws FileError for a folder without a record, and for a copy, whose files have other times.
[[nodiscard]] std::vector<double> recorded_run_times(const std::string& folder);

}  // namespace stonestack::bench
