#pragma once
#include <string>
#include <vector>

#include "rooms.hpp"
#include "stonestack/emulators/simulated_servers.hpp"
#include "stonestack/experiment/simulated_run.hpp"
#include "stonestack/report/record_folder.hpp"
#include "stonestack/report/run_report.hpp"
#include "stonestack/stone/catalogue.hpp"

/// One run of the loop, with its record: what `run` does once and `experiment` often.
namespace stonestack::apps {

/// Outcome of a run.
struct FinishedRun {
  RunReport report;
  Survival survival;      ///< how the tower fares when it is tried further; empty: not tried
  std::string unwritten;  ///< the first file of the record that could not be written, and why; empty: none
};

/// Builds a tower of the stones `present` (indices into the catalogue) and writes options, journal,
/// result.json, report.html and picture into `folder`, in this order. With `file` the simulated devices are
/// served on sockets, and the loop uses the real backends.
[[nodiscard]] FinishedRun perform(const SimulatedRun& run, const Catalogue& catalogue,
                                  const RobotModel& robot, const std::vector<int>& present,
                                  const RecordFolder& folder, const SurvivalOptions* survival = nullptr,
                                  const CellFile* file = nullptr);
/// Performs a run with the devices of a real cell: there is no truth to judge by, and the picture shows what
/// was measured last. The caller has asked for the permission to move.
[[nodiscard]] FinishedRun perform_real(const SimulatedRun& run, const Catalogue& catalogue,
                                       const CellFile& file, const RecordFolder& folder);

}  // namespace stonestack::apps
