#pragma once
#include <string>
#include <vector>

#include "stonestack/experiment/experiment.hpp"

#pragma GCC visibility push(default)

/// Runs of the loop in the simulated cell, and the rows of a comparison of experiments.
namespace stonestack::experiment {

/// Settings of one run of the loop in the simulated cell.
struct SimulatedRun {
  int seed = 1;                  ///< of the cell, detection, search and motion
  BuildOptions build;            ///< options of the loop
  SimulationOptions simulation;  ///< options of the simulated world
};
/// Gives `run.seed` to every part.
void spread_seed(SimulatedRun& run);
/// The options of a run: build, simulation.*
[[nodiscard]] FieldList fields(SimulatedRun& run);

/// "full" leaves the options as they are; "paper" (§4) ends a run at the first placement that fails, with no
/// stone unstacked or reoriented and no second pick. Throws InvalidArgument for another name.
void apply_protocol(SimulatedRun& run, const std::string& protocol);

/// Does what the run reports stand in the simulated world's own state, with the arm away, in both engines:
/// 60 s in Bullet and 5 s in ODE?
[[nodiscard]] TruthReport judge_run(const SimulatedCell& cell, const RunResult& result);

/// One row of a comparison: the experiment with some options set differently.
struct Variant {
  std::string name;                      ///< name of the row
  std::vector<std::string> assignments;  ///< options in which the row differs, NAME=VALUE
};

/// Each way in which the cell is hard, alone, against all of them and none of them.
[[nodiscard]] std::vector<Variant> cell_variants();
/// Each part of the design taken away, alone.
[[nodiscard]] std::vector<Variant> design_variants();
/// "name: option=value, option=value". Throws InvalidArgument.
[[nodiscard]] Variant parse_variant(const std::string& text);

/// Throws InvalidArgument, before anything is built, for an option of a variant that there is not, and for a
/// seed that the runs of an experiment would not have: `run` are the settings of all, `seed` the
/// experiment's.
void check_variants(const std::vector<Variant>& variants, const SimulatedRun& run, int seed);

}  // namespace stonestack::experiment

#pragma GCC visibility pop
