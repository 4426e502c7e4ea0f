#pragma once
#include <vector>

#include "draws.hpp"
#include "walls.hpp"

/// Cost of the next stone of a wall, by the number of stones that stand: `stonestack-bench walls
/// --growth`.
namespace stonestack::bench {

/// Planning of the next stones while others stand.
struct GrowthPoint {
  int standing = 0;   ///< stones when the plan begins
  int planned = 0;    ///< stones that it went on with
  double set_up = 0;  ///< CPU s before the first of them: available stones, stones that stand
  double each = 0;    ///< CPU s of one of them
};

/// A straight wall of three courses of which the last stones are missing, and a plan for these. The wall is a
/// planned piece that stands beside itself as often as it takes, of stones of the same shapes; so the stones
/// to choose from are the same few in every row, and only the number of stones that stand differs.
[[nodiscard]] std::vector<GrowthPoint> measure_wall_growth(const StructureBenchOptions& options,
                                                           const StonePool& pool,
                                                           const std::vector<int>& standing, Draws& draws);

}  // namespace stonestack::bench
