#pragma once
#include <string>

#include "stonestack/experiment/experiment.hpp"

#pragma GCC visibility push(default)

/// Reports of an experiment, for people and for other programs.
namespace stonestack::report {

/// For a person: histogram beside the paper's, times beside the paper's, survival, predictions, a line a run.
[[nodiscard]] std::string experiment_table(const Experiment& experiment);
/// "stonestack.experiment/1".
[[nodiscard]] std::string experiment_json(const Experiment& experiment);
/// Reads a file that experiment_json wrote. Not in it: catalogue, options and belief of the runs.
/// @throws FileError
[[nodiscard]] Experiment read_experiment(const std::string& path);
/// A line a run: run, seed, stones, height, end, times.
[[nodiscard]] std::string runs_csv(const Experiment& experiment);
/// The paper's figure 5: cost of each selected pose by level, a colour a run, a ring where the placement held
/// and a cross where it failed; as CSV and as SVG.
[[nodiscard]] std::string figure5_csv(const Experiment& experiment);
[[nodiscard]] std::string figure5_svg(const Experiment& experiment);

}  // namespace stonestack::report

#pragma GCC visibility pop
