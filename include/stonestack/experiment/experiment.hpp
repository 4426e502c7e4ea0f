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
  std::vector<StoneIndex>
      stones;          ///< from the table up, indices into the catalogue: each rests on the one below it
  StandVerdict stand;  ///< of the world with the arm away; `standing` counts clean stones that stayed
};

/// How far a stone of the true tower may move and still count as standing: stones settle a little once the
/// fingers have gone (measured: up to 0.4 mm and 1.1 deg), those that slide or rock go further.
[[nodiscard]] StandOptions tower_bounds();

/// How a finished tower is tried: waiting, then shaking.
struct SurvivalOptions {
  std::vector<double> seconds{5.0, 60.0, 600.0};  ///< simulated, rising; looked at each of these
  Shake shake = {};                               ///< once along x and once along y
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
/// `engine` is bullet or ode; throws InvalidArgument for another.
[[nodiscard]] TowerVerdict judge_tower(const SimulatedCell& cell,
                                       const StandOptions& options = tower_bounds(),
                                       const std::string& engine = "bullet");
/// Judges a wall likewise: of the stones `claimed` those that are there, within 30 mm and 20 deg, are
/// `stones`; `standing` counts those of them that stay. It stands if all that are claimed are there and stay.
[[nodiscard]] TowerVerdict judge_wall(const SimulatedCell& cell, const std::vector<PlacedStone>& claimed,
                                      const StandOptions& options = tower_bounds(),
                                      const std::string& engine = "bullet");
/// Simulates the tower at the assumed site at rest, and separately shakes it; `bounds` says how
/// far a stone may move to count as standing. Where a `wall` is given, the stones of it that are there are
/// tried instead; of a wall all stones that stay count, in `shaken` those that end within 10 mm.
[[nodiscard]] Survival try_tower(const SimulatedCell& cell, const SurvivalOptions& options = {},
                                 const StandOptions& bounds = tower_bounds(),
                                 const std::vector<PlacedStone>& wall = {});

/// Verdict of one physics engine on the finished tower.
struct EngineVerdict {
  std::string engine;    ///< bullet or ode
  int height = 0;        ///< stones that rest on the stone below and on nothing else, and stay
  double seconds = 0.0;  ///< simulated, with the arm away
  double shift = 0.0;    ///< largest movement of a tower stone in that time [m]
  double turn = 0.0;     ///< likewise [rad]
  std::string note;      ///< what ended the tower; empty: its top
};

/// Verdict of the simulated cell's truth on the finished tower; the program under test never sees it. A stone
/// counts if it stands in every engine.
struct TruthReport {
  int height = 0;                      ///< stones that rest on the stone below and on nothing else
  bool stands = false;                 ///< the tower that the run reports still stands after `seconds`
  double seconds = 60.0;               ///< simulated, with the arm away; of the longest trial
  double shift = 0.0;                  ///< largest movement of a tower stone in that time [m]
  double turn = 0.0;                   ///< likewise [rad]
  std::string note;                    ///< remark on the verdict, for a person
  std::vector<EngineVerdict> engines;  ///< of the same tower; empty in records of older versions
};
/// True where a tower is higher in one engine than in another.
[[nodiscard]] bool engines_disagree(const TruthReport& truth);

/// A stone that the arm's camera modelled.
struct StoneModelReport {
  std::string name;         ///< name in the catalogue that was made
  bool turned = false;      ///< seen in two resting poses
  int views = 0;            ///< that show it
  double seen_share = 0.0;  ///< of its surface
  double sigma = 0.0;       ///< median standard deviation of its surface [m]
  double mass = 0.0;        ///< [kg]
  bool weighed = false;     ///< in the gripper; otherwise the mass is from the density
  std::string note;         ///< why it was not turned, or not found again; empty otherwise
};

/// Stones that nobody scanned, as they were modelled before the run.
struct ModellingReport {
  std::string folder;                    ///< catalogue that was made
  int views = 0;                         ///< of the field
  double seconds = 0.0;                  ///< by the cell's clock [s]
  double apart_before = 0.0;             ///< median distance of surfaces between views as reported [m]
  double apart_after = 0.0;              ///< the same once the views agree [m]
  std::vector<StoneModelReport> stones;  ///< in the order of the catalogue
  std::vector<std::string> left_out;     ///< objects that no stone was made of, with the reason
};

/// Everything that is reported of a run.
struct RunReport {
  RunResult result;                       ///< result of the loop
  std::string version;                    ///< of the program that made it; empty: unknown
  std::string robot;                      ///< name of the robot
  std::string catalogue;                  ///< path of the catalogue
  std::string structure = "tower";        ///< structure that was ordered: tower, wall or bridge
  int seed = 0;                           ///< seed of the run
  std::string cell;                       ///< named set of the simulated cell's errors; empty: a real cell
  std::vector<std::string> cell_changes;  ///< "NAME=VALUE" of what is not as that set has it
  std::string safety_checksum;            ///< of the arm's controller; empty: none was said
  std::vector<std::string> present;       ///< names of the stones that were in the field
  std::optional<TruthReport> truth;       ///< simulated cell only
  std::string options_text;               ///< resolved options, YAML
  std::string picture;  ///< path of the PNG; empty: none. The JSON names it beside result.json
  std::optional<ModellingReport> modelling;  ///< of a run whose stones nobody scanned
};

/// One run of an experiment.
struct ExperimentRun {
  RunReport report;   ///< report of the run
  Survival survival;  ///< at the times of SurvivalOptions
  int number = 0;     ///< number in the experiment, from 1
};

/// Part of an experiment: every `count`-th run, from run `index` on. By default it is all of them.
struct Shard {
  int index = 1;  ///< from 1 to `count`
  int count = 1;  ///< shards that the experiment is divided into
  /// True for a run of this shard; `run` from 1.
  [[nodiscard]] bool has(int run) const { return (run - 1) % count == index - 1; }
  /// Number of its runs in an experiment of `total` runs.
  [[nodiscard]] int size(int total) const { return (total + count - index) / count; }
};
/// "2/8": the second of eight. Throws InvalidArgument for another form, and unless index is from 1 to count.
[[nodiscard]] Shard parse_shard(const std::string& text);
/// The form that parse_shard reads.
[[nodiscard]] std::string to_text(const Shard& shard);

/// Runs that are done, in order, and how they were made.
struct Experiment {
  std::string title;                ///< "11 runs of 4 of 6 stones, seed 1"
  int seed = 0;                     ///< run k has the seed 1000 seed + k
  int total = 0;                    ///< runs that were ordered, of all shards; 0: unknown, in older records
  Shard shard;                      ///< runs of the experiment that are performed here
  std::vector<std::string> stones;  ///< names that all runs draw from; empty with `new_stones`
  std::string protocol = "full";    ///< when a run ends: full or paper (`apply_protocol`)
  int per_run = 4;                  ///< stones in the field of each run
  int new_stones = 0;               ///< stones that each run had for itself; 0: all runs drew from the same
  std::string new_stones_from;      ///< folder that they were drawn from; empty: generated
  std::vector<double> survival_seconds{5.0, 60.0,
                                       600.0};  ///< times [s] at which the survival of a tower is judged
  std::vector<ExperimentRun> runs;              ///< runs, in the order of their seeds
};

/// A share with its 95 % interval: Wilson's score interval at the effective number of trials. Runs that share
/// a set of stones are a cluster, and so are all placements of such runs: the effective number is
/// trials / design effect, times (t of trials - 1 / t of clusters - 1)^2 for the few degrees of freedom of
/// few clusters (Korn and Graubard 1998). The design effect (Kish 1965) is estimated between 1 and its value
/// where all trials of a cluster end alike; where nothing shows it (no hits, hits only, or one cluster), it
/// is the latter. With one trial a cluster this is Wilson's interval.
struct Rate {
  int hits = 0;            ///< successes
  int trials = 0;          ///< tries in all
  int clusters = 0;        ///< sets of stones; 0: every trial is on its own
  double effective = 0.0;  ///< number of trials that count; 0: all of them
  /// Estimate of the probability, hits over trials; 0 without trials.
  [[nodiscard]] double share() const { return trials > 0 ? static_cast<double>(hits) / trials : 0.0; }
  /// Lower end of the 95 % interval.
  [[nodiscard]] double low() const;
  /// Upper end of the 95 % interval.
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
/// Height of a run by the paper's protocol (§4): stones placed before the first that was not. What the loop
/// did after that, unstacking, reorienting and a second pick do not count. A run without a failure has its
/// judged height, if that is less.
[[nodiscard]] int paper_height(const RunReport& report);
/// Counts of runs by that height.
[[nodiscard]] std::vector<int> paper_heights(const Experiment& experiment);
/// Runs that reached at least `height` by the paper's protocol.
[[nodiscard]] Rate reached_by_paper(const Experiment& experiment, int height);
/// How many sets of stones the runs had.
[[nodiscard]] int stone_sets(const Experiment& experiment);

/// Predicted against observed: placements by predicted success.
struct CalibrationBin {
  double low = 0.0;              ///< lower limit of the prediction, included
  double high = 1.0;             ///< upper limit, included in the last bin only
  double mean_prediction = 0.0;  ///< mean of the predictions in the bin
  Rate observed;                 ///< placements that were seen placed
};
/// Sorts the placements that were tried into `bins` equal intervals of their predicted success.
[[nodiscard]] std::vector<CalibrationBin> calibration(const Experiment& experiment, int bins = 5);

}  // namespace stonestack::experiment

#pragma GCC visibility pop
