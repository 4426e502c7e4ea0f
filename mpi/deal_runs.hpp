#pragma once
#include <functional>
#include <string>

#include "ranks.hpp"
#include "stonestack/report/record_run.hpp"

namespace stonestack::mpi {

using namespace report;

/// Performs the experiment with all ranks and keeps its record, on rank 0. Runs are dealt one by one, since
/// their times differ by ten; this rank performs runs, too. `listener` hears lines about runs
/// that have ended.
/// @throws what record_experiment throws, and Error for what another rank reports; the runs till then are in
/// the record
[[nodiscard]] RecordedExperiment deal_runs(const Ranks& ranks, ExperimentOrder order,
                                           const Catalogue& catalogue,
                                           const std::function<void(const std::string& lines)>& listener);

/// Performs the runs that rank 0 deals to this rank, until there are none.
void perform_dealt_runs(const Ranks& ranks, const ExperimentOrder& order, const Catalogue& catalogue);

}  // namespace stonestack::mpi
