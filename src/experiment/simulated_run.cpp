#include "stonestack/experiment/simulated_run.hpp"

#include <algorithm>

#include "stonestack/core/error.hpp"

namespace stonestack::experiment {
namespace {

constexpr double kSecondsInOde = 5.0;  // simulated: a tower that ODE lets fall has moved by then
constexpr double kStepInOde = 0.0005;  // s

EngineVerdict verdict_of(const std::string& engine, const TowerVerdict& tower, double seconds) {
  return {engine, tower.stand.standing, seconds, tower.stand.shift, tower.stand.turn, tower.stand.reason};
}

}  // namespace

void spread_seed(SimulatedRun& run) {
  run.build.search.seed = run.build.detection.seed = run.build.motion.seed = run.simulation.seed = run.seed;
}

FieldList fields(SimulatedRun& run) {
  return join({fields(run.build), nest("simulation", fields(run.simulation))});
}

void apply_protocol(SimulatedRun& run, const std::string& protocol) {
  require(protocol == "full" || protocol == "paper", "no protocol is called '", protocol,
          "'; there are full and paper");
  if (protocol == "full") return;
  run.build.max_failures = run.build.pick_attempts = 1;
  run.build.max_unstacked = run.build.max_reoriented = 0;
}

TruthReport judge_run(const SimulatedCell& cell, const RunResult& result) {
  const StandOptions options = tower_bounds();
  StandOptions in_ode = options;
  in_ode.seconds = kSecondsInOde;
  in_ode.step = kStepInOde;
  const std::vector<PlacedStone> claimed = stacking::at_rest(result.world).stack;
  const auto judged = [&](const StandOptions& how, const std::string& engine) {
    return result.wall ? judge_wall(cell, claimed, how, engine) : judge_tower(cell, how, engine);
  };
  const TowerVerdict verdict = judged(options, "bullet"), other = judged(in_ode, "ode");
  TruthReport truth;
  truth.engines = {verdict_of("bullet", verdict, options.seconds), verdict_of("ode", other, in_ode.seconds)};
  truth.height = std::min(verdict.stand.standing, other.stand.standing);
  truth.stands = verdict.stand.stands && other.stand.stands && truth.height >= result.height;
  truth.seconds = options.seconds;
  truth.shift = verdict.stand.shift;
  truth.turn = verdict.stand.turn;
  truth.note = verdict.stand.reason;
  if (truth.note.empty() && !other.stand.reason.empty()) truth.note = "in ODE " + other.stand.reason;
  return truth;
}

bool engines_disagree(const TruthReport& truth) {
  return std::any_of(truth.engines.begin(), truth.engines.end(),
                     [&](const EngineVerdict& verdict) { return verdict.height != truth.height; });
}

}  // namespace stonestack::experiment
