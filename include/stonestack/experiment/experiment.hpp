#pragma once
#include <optional>
#include <string>
#include <vector>

#include "stonestack/physics/stack.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"

#pragma GCC visibility push(default)

/// The paper's experiment (§4): consecutive runs, their heights, costs, times and what the predictions were
/// worth.
namespace stonestack::experiment {

/// The true tower: which stones stand on each other at the site, and whether they stay.
struct TowerVerdict {
  std::vector<int> stones;  ///< from the table up, indices into the catalogue: each rests on the one below it
  StandVerdict stand;       ///< of the world with the arm away; `standing` counts clean stones that stayed
};

/// How far a stone of the true tower may move and still count as standing: stones settle a little once the
/// fingers have gone (measured: up to 0.4 mm and 1.1 deg), those that slide or rock go further.
[[nodiscard]] StandOptions tower_bounds();

/// How a finished tower is tried: waiting, then shaking.
struct SurvivalOptions {
  std::vector<double> seconds{5.0, 60.0, 600.0};  ///< simulated, rising; looked at each of these
  double shake_acceleration = 2.0;                ///< amplitude, level, once along x and once along y [m/s^2]
  double shake_frequency = 2.4;                   ///< [Hz]
  double shake_seconds = 0.7;                     ///< then half a second of rest
};

/// Height that is left of the tower.
struct Survival {
  std::vector<int>
      standing;    ///< stones from the table up that stayed within the bounds, at each of `seconds`
  int shaken = 0;  ///< stones that are still a clean tower after the worse of the two shakes
};

/// Judges the tower at the assumed site in a world of its own, without the arm and with every stone free,
/// for `seconds` (simulated) of the options; friction is the true one of each pair. The tower is the chain of
/// stones from the one on the table nearest to the site up, each of which rests on the last and nothing else.
[[nodiscard]] TowerVerdict judge_tower(const SimulatedCell& cell,
                                       const StandOptions& options = tower_bounds());
/// Simulates the tower at the assumed site at rest, and separately shakes it; `bounds` says how
/// far a stone may move to count as standing.
[[nodiscard]] Survival try_tower(const SimulatedCell& cell, const SurvivalOptions& options = {},
                                 const StandOptions& bounds = tower_bounds());

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
  std::string cell;                       ///< named set of the simulated cell's errors; empty: a real cell
  std::vector<std::string> cell_changes;  ///< "NAME=VALUE" of what is not as that set has it
  std::vector<std::string> present;       ///< names of the stones that were in the field
  std::optional<TruthReport> truth;       ///< simulated cell only
  std::string options_text;               ///< resolved options, YAML
  std::string picture;  ///< path of the PNG; empty: none. The JSON names it beside result.json
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
