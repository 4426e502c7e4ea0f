#pragma once
#include <optional>
#include <string>
#include <vector>

#include "stonestack/experiment/judge_tower.hpp"
#include "stonestack/stacking/build_tower.hpp"

#pragma GCC visibility push(default)

/// The paper's experiment (§4): consecutive runs, their heights, costs, times and what the predictions were
/// worth.
namespace stonestack::experiment {

/// Verdict of the simulated cell's truth on the finished tower; the program under test never sees it.
struct TruthReport {
  int height = 0;         ///< stones that rest on the stone below and on nothing else
  bool stands = false;    ///< the tower that the run reports still stands after `seconds`
  double seconds = 60.0;  ///< simulated, with the arm away
  double shift = 0.0;     ///< largest movement of a tower stone in that time [m]
  double turn = 0.0;      ///< likewise [rad]
  std::string note;
};

/// Everything that is reported of a run.
struct RunReport {
  RunResult result;
  std::string version;  ///< of the program that made it; empty: unknown
  std::string robot;
  std::string catalogue;
  int seed = 0;
  std::vector<std::string> present;  ///< names of the stones that were in the field
  std::optional<TruthReport> truth;  ///< simulated cell only
  std::string options_text;          ///< resolved options, YAML
  std::string picture;               ///< path of the PNG; empty: none. The JSON names it beside result.json
};

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
/// A pose that was selected and tried: not a stone that the gripper missed or dropped, nor one that was
/// unstacked or reoriented.
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

}  // namespace stonestack::experiment

#pragma GCC visibility pop
