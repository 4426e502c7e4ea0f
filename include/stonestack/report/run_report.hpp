#pragma once
#include <string>
#include <vector>

#include "stonestack/experiment/experiment.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/stone/catalogue.hpp"

#pragma GCC visibility push(default)

/// Reports of a run and of an experiment, for people and for other programs.
namespace stonestack::report {

/// "stonestack.run/1" (README, "Output formats"): one JSON object, times included.
[[nodiscard]] std::string run_json(const RunReport& report);
/// The table that a person reads at the end of a run: stone, cost and its terms, planned and measured pose,
/// outcome, times.
[[nodiscard]] std::string run_table(const RunReport& report);
/// One self-contained HTML file: the cell in 3-D over the whole time of the run, decisions with the
/// placements that were compared, tables, times, the paper's figure 5, options. Without WebGL it shows the
/// picture `report.picture`. Throws FileError if that cannot be read.
[[nodiscard]] std::string run_html(const RunReport& report, const Catalogue& catalogue,
                                   const RobotModel& robot);
/// For a person: histogram beside the paper's, times beside the paper's, survival, predictions, a line a run.
[[nodiscard]] std::string experiment_table(const Experiment& experiment);
/// "stonestack.experiment/1".
[[nodiscard]] std::string experiment_json(const Experiment& experiment);
/// Reads a file that experiment_json wrote. It omits catalogue, options and estimates of the runs. Throws
/// FileError.
[[nodiscard]] Experiment read_experiment(const std::string& path);
/// A line a run: run, seed, stones, height, end, times.
[[nodiscard]] std::string runs_csv(const Experiment& experiment);
/// The paper's figure 5: cost of each selected pose by level, a colour a run, a ring where the placement held
/// and a cross where it failed; as CSV and as SVG.
[[nodiscard]] std::string figure5_csv(const Experiment& experiment);
/// Costs of all placements by level, held or fallen, as the paper's figure 5, in SVG.
[[nodiscard]] std::string figure5_svg(const Experiment& experiment);

}  // namespace stonestack::report

#pragma GCC visibility pop
