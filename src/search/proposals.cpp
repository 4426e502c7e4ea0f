#include "search/proposals.hpp"

#include <algorithm>
#include <cmath>

#include "physics/shape.hpp"
#include "search/constants.hpp"
#include "search/parallel.hpp"

namespace stonestack::search {
namespace {

constexpr std::size_t kRefined = 24;      ///< a stone (measured)
constexpr double kDistinctAngle = 0.14;   ///< [rad]
constexpr double kDistinctShift = 0.010;  ///< [m]
constexpr double kSideCell = 0.005;       ///< [m]

}  // namespace

Eigen::Matrix3d levelled(const Eigen::Matrix3d& R_W_O, const Landing& landing) {
  const Eigen::Vector3d axis(landing.b, -landing.a, 0.0);
  const double slope = axis.norm();
  if (slope < 1e-12) return R_W_O;
  return Eigen::AngleAxisd(std::atan(slope), axis / slope) * R_W_O;
}

bool distinct(const BodyPose& p, const BodyPose& q) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(p.R_W_O.transpose() * q.R_W_O));
  return std::abs(turn.angle()) > kDistinctAngle || (p.p_W_M - q.p_W_M).head<2>().norm() > kDistinctShift;
}

std::vector<Proposal> best_distinct(std::vector<Proposal> list, std::size_t keep,
                                    const std::function<double(const Proposal&)>& value) {
  std::stable_sort(list.begin(), list.end(),
                   [&](const Proposal& p, const Proposal& q) { return value(p) > value(q); });
  std::vector<Proposal> kept;
  for (const Proposal& p : list) {
    if (kept.size() == keep) break;
    const auto differs = [&](const Proposal& q) { return p.stone != q.stone || distinct(p.body, q.body); };
    if (std::all_of(kept.begin(), kept.end(), differs)) kept.push_back(p);
  }
  return kept;
}

std::vector<LooseStone> on_resting_sides(std::span<const LooseStone> stones, double max_slope,
                                         const SearchOptions& options) {
  const StackField table = stack_field({}, stones, {0, 0}, kSideCell, options);
  std::vector<LooseStone> kept(stones.begin(), stones.end());
  run_tasks(options.threads, kept.size(), [&](std::size_t s) {
    GapField buffer;
    const StoneGeometry& stone = *kept[s].geometry;
    std::erase_if(kept[s].orientations, [&](const Eigen::Matrix3d& R_W_O) {
      const Underside side = make_underside(stone.vertices_M, stone.faces, R_W_O, underside_options(table));
      lay(table.surface, side, 0, 0, underside_options(table).cut, &buffer);
      return !solve_rest(buffer, table.surface, max_slope).rests;
    });
  });
  return kept;
}

UndersideOptions underside_options(const StackField& stack) {
  UndersideOptions options;
  options.cell = stack.surface.heights.cell;
  options.stride = stack.surface.heights.stride;
  return options;
}

StackField stack_field(const StackBodies& stack, std::span<const LooseStone> stones,
                       const Eigen::Vector2d& site, double cell, const SearchOptions& options) {
  double radius = 0.0;
  for (const LooseStone& stone : stones)
    radius = std::max({radius, stone.geometry->radius, stone.raster_radius});
  SurfaceGrid grid;
  grid.centre = stack.bodies.empty() ? site : Eigen::Vector2d(stack.bodies.back().p_W_M.head<2>());
  grid.cell = cell;
  grid.half = static_cast<int>(std::ceil((radius + kOffsetReach + 0.03) / cell));
  return {top_surface(stack.bodies, grid, kCleanHeight), interfaces(stack), options.friction};
}

Proposals propose(const StackBodies& stack, std::span<const LooseStone> stones, const Eigen::Vector2d& site,
                  int keep, const SearchOptions& options) {
  const bool on_table = stack.bodies.empty();
  const StackField coarse = stack_field(stack, stones, site, options.grid, options);
  const StackField fine = stack_field(stack, stones, site, 0.5 * options.grid, options);
  const Proposals surveyed = coarse_proposals(coarse, on_table, stones, kRefined, options);
  std::vector<Refined> candidates(surveyed.list.size());
  run_tasks(options.threads, candidates.size(),
            [&](std::size_t k) { candidates[k] = refined(surveyed.list[k], fine, on_table, options); });
  Proposals result;
  result.evaluated = surveyed.evaluated;
  for (const Refined& candidate : candidates) result.evaluated += candidate.evaluated;
  for (const LooseStone& stone : stones) {
    std::vector<Proposal> of_stone;
    for (const auto& [p, evaluated] : candidates)
      if (p.stone == stone.stone && p.landing.holds && p.robust > 0.0) of_stone.push_back(p);
    of_stone = best_distinct(std::move(of_stone), static_cast<std::size_t>(keep),
                             [](const Proposal& p) { return p.robust; });
    result.list.insert(result.list.end(), of_stone.begin(), of_stone.end());
  }
  return result;
}

}  // namespace stonestack::search
