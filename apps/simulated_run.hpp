#pragma once
#include <string>
#include <vector>

#include "rooms.hpp"
#include "stonestack/experiment/simulated_run.hpp"
#include "stonestack/report/run_report.hpp"
#include "stonestack/stone/catalogue.hpp"

/// One run of the loop, with its record: what `run` does once and `experiment` often.
namespace stonestack::apps {

struct CellFile;

/// The report, and how the tower fares when it is tried further (`survival` null: not tried).
struct FinishedRun {
  RunReport report;
  Survival survival;
};

/// Builds a tower of the stones `present` (indices into the catalogue) and writes journal, options, picture,
/// result.json and report.html into `folder`. With `file` the simulated devices are served on sockets, and
/// the loop uses the real backends. Throws InvalidArgument when the folder holds a run already.
[[nodiscard]] FinishedRun perform(const SimulatedRun& run, const Catalogue& catalogue,
                                  const RobotModel& robot, const std::vector<int>& present,
                                  const std::string& folder, const SurvivalOptions* survival = nullptr,
                                  const CellFile* file = nullptr);
/// The same with the devices of a real cell: there is no truth to judge by, and the picture shows what was
/// measured last. The caller has asked for the permission to move.
[[nodiscard]] RunReport perform_real(const SimulatedRun& run, const Catalogue& catalogue,
                                     const CellFile& file, const std::string& folder);

}  // namespace stonestack::apps
