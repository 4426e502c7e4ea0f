#pragma once
#include <string>
#include <vector>

#include "stonestack/report/run_report.hpp"
#include "stonestack/simulation/simulated_cell.hpp"

/// The paper's experiment (§4): consecutive runs, their heights, costs, times and what the predictions were
/// worth.
namespace stonestack::report {

/// One run of an experiment.
struct ExperimentRun {
  RunReport report;
  Survival survival;  ///< at the times of SurvivalOptions
};

/// All runs, in order, and how they were made.
struct Experiment {
  std::string title;  ///< "11 runs of 4 of 6 stones, seed 1"
  int per_run = 4;
  std::vector<double> survival_seconds{5.0, 60.0, 600.0};
  std::vector<ExperimentRun> runs;
};

/// A share with its 95 % interval (Wilson's score interval).
struct Rate {
  int hits = 0, trials = 0;
  [[nodiscard]] double share() const { return trials > 0 ? static_cast<double>(hits) / trials : 0.0; }
  [[nodiscard]] double low() const;
  [[nodiscard]] double high() const;
};

/// Height of a run as its true world held it after the judge's wait: never more than the run reported.
[[nodiscard]] int judged_height(const ExperimentRun& run);
/// A pose that was selected and tried: not a stone that the gripper missed or dropped, nor one that was taken
/// off or turned over.
[[nodiscard]] bool was_tried(const PlacementRecord& record);
/// How many runs reached height 0, 1, ..., `per_run`.
[[nodiscard]] std::vector<int> heights(const Experiment& experiment);
/// Runs that reached at least `height`.
[[nodiscard]] Rate reached(const Experiment& experiment, int height);

/// Predicted against observed: placements by predicted success.
struct CalibrationBin {
  double low = 0.0, high = 1.0;  ///< of the prediction, [low, high), the last closed
  double mean_prediction = 0.0;
  Rate observed;  ///< placements that were seen placed
};
[[nodiscard]] std::vector<CalibrationBin> calibration(const Experiment& experiment, int bins = 5);

/// For a person: histogram beside the paper's, times beside the paper's, survival, predictions, a line a run.
[[nodiscard]] std::string experiment_table(const Experiment& experiment);
/// "stonestack.experiment/1".
[[nodiscard]] std::string experiment_json(const Experiment& experiment);
/// What experiment_json wrote into a file. Not in it: catalogue, options and belief of the runs. Throws
/// FileError.
[[nodiscard]] Experiment read_experiment(const std::string& path);
/// A line a run: run, seed, stones, height, end, times.
[[nodiscard]] std::string runs_csv(const Experiment& experiment);
/// The paper's figure 5: cost of each selected pose by level, a colour a run, a ring where the placement held
/// and a cross where it failed; as CSV and as SVG.
[[nodiscard]] std::string figure5_csv(const Experiment& experiment);
[[nodiscard]] std::string figure5_svg(const Experiment& experiment);

}  // namespace stonestack::report
