#pragma once
#include <vector>

#include "stonestack/physics/stack.hpp"
#include "stonestack/simulation/simulated_cell.hpp"

#pragma GCC visibility push(default)

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
/// Simulates the tower at the assumed site at rest, and separately shakes it from its present state; `bounds`
/// says how far a stone may move to count as standing.
[[nodiscard]] Survival try_tower(const SimulatedCell& cell, const SurvivalOptions& options = {},
                                 const StandOptions& bounds = tower_bounds());

}  // namespace stonestack::experiment

#pragma GCC visibility pop
