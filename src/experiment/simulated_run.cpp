#include "stonestack/experiment/simulated_run.hpp"

namespace stonestack::experiment {

void spread_seed(SimulatedRun& run) {
  run.build.search.seed = run.build.detection.seed = run.build.motion.seed = run.simulation.seed = run.seed;
}

FieldList fields(SimulatedRun& run) {
  return join({fields(run.build), nest("simulation", fields(run.simulation))});
}

TruthReport judge_run(const SimulatedCell& cell, const RunResult& result) {
  const StandOptions options = tower_bounds();
  const TowerVerdict verdict = judge_tower(cell, options);
  TruthReport truth;
  truth.height = verdict.stand.standing;
  truth.stands = verdict.stand.stands && truth.height >= result.height;
  truth.seconds = options.seconds;
  truth.shift = verdict.stand.shift;
  truth.turn = verdict.stand.turn;
  truth.note = verdict.stand.reason;
  return truth;
}

}  // namespace stonestack::experiment
