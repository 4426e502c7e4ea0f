#pragma once
#include <CLI/CLI.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "draws.hpp"
#include "rooms.hpp"
#include "stonestack/search/find_next_pose.hpp"
#include "stonestack/stone/stone.hpp"

/// Stones that benchmarks draw from, and the draws.
namespace stonestack::bench {

/// Options of benchmarks of the search alone, by their protocol: stones in any attitude, exact centres of
/// mass, placements within 1 mm and 0.5 deg.
[[nodiscard]] inline SearchOptions search_without_robot() {
  SearchOptions options;
  options.max_tilt = M_PI;
  options.com_sigma = 0.0;
  options.placement_sigma_translation = 0.001;
  options.placement_sigma_rotation = 0.0087266;
  return options;
}

/// Where stones come from.
struct PoolOptions {
  int generated = 12;                            ///< limestones made on the spot
  std::string scans = "../shared/stones/scans";  ///< folder of OBJ files; skipped when it is not there
  std::string catalogue;                         ///< one more pool

  /// --generated, --scans, --catalogue.
  void register_on(CLI::App& command);
};

/// Stones that are drawn from together, with shapes for the search and finer ones for the verdict.
struct StonePool {
  std::string name;
  std::vector<Stone> stones;
  ShapeList shapes, fine;
};
/// Throws FileError for a catalogue that cannot be read and for a folder of scans without one,
/// InvalidArgument if nothing is left to draw from.
[[nodiscard]] std::vector<StonePool> read_pools(const PoolOptions& options);
/// Pools of the same stones without shapes.
[[nodiscard]] std::vector<StonePool> read_pool_stones(const PoolOptions& options);
/// Pools with shapes where draws are performed, else without.
[[nodiscard]] std::vector<StonePool> read_pools(const PoolOptions& options, const Draws& draws);

/// Draw k: `count` different stones, and how they lie before they are picked up.
[[nodiscard]] SearchProblem draw_problem(const StonePool& pool, int seed, int k, int count);

}  // namespace stonestack::bench
