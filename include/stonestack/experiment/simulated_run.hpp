#pragma once
#include "stonestack/experiment/experiment.hpp"

#pragma GCC visibility push(default)

namespace stonestack::experiment {

/// Settings of one run of the loop in the simulated cell.
struct SimulatedRun {
  int seed = 1;  ///< of the cell, detection, search and motion
  BuildOptions build;
  SimulationOptions simulation;
};
/// Gives `run.seed` to every part.
void spread_seed(SimulatedRun& run);
/// The options of a run: build, simulation.*
[[nodiscard]] FieldList fields(SimulatedRun& run);

/// Does what the run reports stand in the simulated world's own state, with the arm away?
[[nodiscard]] TruthReport judge_run(const SimulatedCell& cell, const RunResult& result);

}  // namespace stonestack::experiment

#pragma GCC visibility pop
