#pragma once
#include "bench.hpp"
#include "ode_witness.hpp"
#include "settings.hpp"
#include "stone_draws.hpp"
#include "stonestack/search/plan_wall.hpp"

namespace stonestack::search {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(WallMetrics, placed, asked, length, height, width, fill, face, joints,
                                   open_joints, flatness, margin, spanned, to_span)
}  // namespace stonestack::search

namespace stonestack::bench {

/// Options of benchmarks that plan structures of drawn stones and judge them.
struct StructureBenchOptions {
  int draws = 10, stones = 12, seed = 1;
  Judges judges;
  PoolOptions pools;
  SearchOptions search = search_without_robot();
  Settings settings;

  /// --draws, --stones, --friction, --seed, and those of pools, judges and settings.
  void register_on(CLI::App& command);
};

void add_walls(CLI::App& app);
void add_tasks(CLI::App& app);

}  // namespace stonestack::bench
