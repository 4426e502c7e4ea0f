#pragma once
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/physics/stack.hpp"

namespace stonestack {

/// Options of the search. `method`: "default" (gap field proposals, look-ahead) or "paper" (section 3 as
/// written).
struct SearchOptions {
  std::string method = "default";
  double friction = 0.1;         ///< what the planner assumes, paper §4.1
  double theta_init = 0.785398;  ///< rad, paper mode: random initial rotation (companion paper, weak)
  double attraction = 100.0;     ///< N, F
  double e_kin_stable = 0.0002;  ///< J; measured: 20 J filters nothing (facts/paper.md)
  int local_solutions = 5;       ///< x
  int contact_steps = 10;        ///< steps over which contacts are collected
  double w1 = 0.179, w2 = 0.472, w3 = 0.094, w4 = 0.255;  ///< eq. (2)
  double area_reference = 0.002;                          ///< m^2; eq. (2) normalised: A_ref / A
  double energy_reference = 0.0002;                       ///< J
  double distance_reference = 0.1;                        ///< m
  bool si_cost = false;                                   ///< eq. (2) in SI, with the literal units
  double least_margin = 0.02;                             ///< g: a stack below it is not proposed
  int beam = 3;                                           ///< states kept a level in look-ahead
  int threads = 0;                                        ///< 0: all cores; the result does not depend on it
  double budget = 0.0;                                    ///< s; 0: none (deterministic)
  int seed = 1;
};
[[nodiscard]] FieldList fields(SearchOptions& options);

/// A stone and the pose where it should go.
struct Placement {
  int stone = -1;
  Pose T_W_O = Pose::Identity();
  double cost = 0.0;  ///< eq. (2)
  std::map<std::string, double>
      terms;  ///< area, kinetic_energy, distance, normal: weighted terms of eq. (2); margin, ...
  double predicted_success = 0.0;  ///< share of perturbed placements that stand
  SupportPolygon support;
};

/// What is known of the site.
struct SearchProblem {
  const ShapeList* shapes = nullptr;
  Stack stack;  ///< what stands (measured)
  std::vector<PlacedStone>
      available;  ///< loose stones, with their detected poses (paper: initial orientation)
  Eigen::Vector2d site = Eigen::Vector2d::Zero();  ///< where the first stone goes, W
};

struct SearchResult {
  std::vector<Placement> best;  ///< best first, over all stones; several so that motion can refuse some
  std::string reason;           ///< when `best` is empty: what stood in the way
  long candidates = 0;          ///< tried
  double seconds = 0.0;
};
/// The next placement (paper §3). `report` is told about progress from one thread.
[[nodiscard]] SearchResult find_next_pose(const SearchProblem& problem, const SearchOptions& options = {},
                                          const std::function<void(const std::string&)>& report = {});

/// Plans up to `levels` placements as if each had succeeded.
[[nodiscard]] std::vector<Placement> plan_tower(SearchProblem problem, int levels,
                                                const SearchOptions& options, std::string* reason);

}  // namespace stonestack
