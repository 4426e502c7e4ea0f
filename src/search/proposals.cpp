#include "search/proposals.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "search/orientations.hpp"
#include "search/parallel.hpp"

namespace stonestack {
namespace {

constexpr double kOffsetReach = 0.04;   ///< m, offsets from the middle of the top that are tried
constexpr double kOffsetPitch = 0.008;  ///< m
constexpr std::size_t kRefined = 24;    ///< a stone (measured)
constexpr int kRefineRounds = 6;
constexpr double kLevel = 0.02;             ///< tilt that needs no further turning
constexpr double kDistinctAngle = 0.14;     ///< rad
constexpr double kDistinctShift = 0.010;    ///< m
constexpr double kInterfaceTouch = 0.0008;  ///< m

/// Turns a body by the tilt that its landing still asks for.
Eigen::Matrix3d levelled(const Eigen::Matrix3d& R_W_O, const Landing& landing) {
  const Eigen::Vector3d axis(landing.b, -landing.a, 0.0);
  const double slope = axis.norm();
  if (slope < 1e-12) return R_W_O;
  return Eigen::AngleAxisd(std::atan(slope), axis / slope) * R_W_O;
}

bool distinct(const Proposal& p, const Proposal& q) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(p.body.R_W_O.transpose() * q.body.R_W_O));
  return std::abs(turn.angle()) > kDistinctAngle ||
         (p.body.p_W_M - q.body.p_W_M).head<2>().norm() > kDistinctShift;
}

/// Best first by `value`, at most `keep`, none like a better one.
template <class Value>
std::vector<Proposal> best_distinct(std::vector<Proposal> list, std::size_t keep, Value value) {
  std::stable_sort(list.begin(), list.end(),
                   [&](const Proposal& p, const Proposal& q) { return value(p) > value(q); });
  std::vector<Proposal> kept;
  for (const Proposal& p : list) {
    if (kept.size() == keep) break;
    if (std::all_of(kept.begin(), kept.end(), [&](const Proposal& q) { return distinct(p, q); }))
      kept.push_back(p);
  }
  return kept;
}

UndersideOptions underside_options(const StackField& stack) {
  UndersideOptions options;
  options.cell = stack.surface.heights.cell;
  options.stride = stack.surface.heights.stride;
  return options;
}

Proposal make_proposal(const LooseStone& stone, const StackField& stack, const Eigen::Matrix3d& R_W_O, int i,
                       int j, const Landing& landing) {
  Proposal proposal;
  proposal.stone = stone.stone;
  proposal.landing = landing;
  proposal.body.stone = stone.geometry;
  proposal.body.R_W_O = R_W_O;
  proposal.body.p_W_M << stack.surface.heights.node(stack.surface.heights.index(i, j)), landing.height;
  return proposal;
}

/// The best offset of every yaw of one orientation.
std::vector<Proposal> try_orientation(const LooseStone& stone, const Eigen::Matrix3d& R_W_O,
                                      const StackField& stack, bool on_table, int yaws) {
  std::vector<Proposal> found;
  GapField buffer;
  const double cell = stack.surface.heights.cell;
  OffsetGrid offsets;
  offsets.step = std::max(1, static_cast<int>(std::lround(kOffsetPitch / cell)));
  offsets.n = static_cast<int>(std::lround(kOffsetReach / (cell * offsets.step)));
  for (int yaw = 0; yaw < (on_table ? 1 : yaws); ++yaw) {
    const Eigen::Matrix3d R = yaw_rotation(6.283185307179586 * yaw / yaws) * R_W_O;
    const Underside underside =
        make_underside(stone.geometry->vertices_M, stone.geometry->faces, R, underside_options(stack));
    if (on_table) {
      const Landing landing = land_on_table(stack, underside, &buffer);
      if (landing.holds) found.push_back(make_proposal(stone, stack, R, 0, 0, landing));
      continue;
    }
    const LandingGrid grid = land(stack, underside, stone.geometry->mass, offsets, &buffer);
    const Landing* best = nullptr;
    int best_u = 0, best_v = 0;
    for (int v = 1 - offsets.n; v < offsets.n; ++v)
      for (int u = 1 - offsets.n; u < offsets.n; ++u)
        if (const Landing& landing = grid.at(u, v);
            landing.holds && (best == nullptr || landing.estimate > best->estimate)) {
          best = &landing;
          best_u = u;
          best_v = v;
        }
    if (best != nullptr)
      found.push_back(make_proposal(stone, stack, R, best_u * offsets.step, best_v * offsets.step, *best));
  }
  return found;
}

/// Mean estimate under the placement uncertainty, from the landings around the middle.
double robust_estimate(const LandingGrid& grid, double pitch, double sigma) {
  double sum = 0.0, weights = 0.0;
  for (int v = 1 - grid.offsets.n; v < grid.offsets.n; ++v) {
    for (int u = 1 - grid.offsets.n; u < grid.offsets.n; ++u) {
      const double square = (u * u + v * v) * pitch * pitch;
      const double weight = std::exp(-0.5 * square / std::max(sigma * sigma, 1e-8));
      sum += weight * grid.at(u, v).estimate;
      weights += weight;
    }
  }
  return sum / weights;
}

/// Levels a proposal and walks to the best offset nearby on the finer raster, until both are at rest.
Proposal refined(const Proposal& start, const StackField& stack, bool on_table, const SearchOptions& options,
                 long* evaluated) {
  GapField buffer;
  Proposal best = start;
  best.landing.holds = false;
  best.robust = -1.0;
  Eigen::Matrix3d R = levelled(start.body.R_W_O, start.landing);
  const HeightRaster& heights = stack.surface.heights;
  const Eigen::Vector2d from = (start.body.p_W_M.head<2>() - heights.centre) / heights.cell;
  OffsetGrid offsets;
  offsets.i = static_cast<int>(std::lround(from.x()));
  offsets.j = static_cast<int>(std::lround(from.y()));
  offsets.n = on_table ? 0 : 3;
  offsets.step = 1;
  const int limit = static_cast<int>(std::ceil((kOffsetReach + 0.01) / heights.cell)) - offsets.n;
  for (int round = 0; round < kRefineRounds; ++round) {
    const Underside underside =
        make_underside(start.body.stone->vertices_M, start.body.stone->faces, R, underside_options(stack));
    Landing landing;
    double robust = 0.0;
    int u_best = 0, v_best = 0;
    if (on_table) {
      landing = land_on_table(stack, underside, &buffer);
      robust = landing.estimate;
      ++*evaluated;
    } else {
      const LandingGrid grid = land(stack, underside, start.body.stone->mass, offsets, &buffer);
      *evaluated += static_cast<long>(grid.landings.size());
      landing = grid.at(0, 0);
      robust = robust_estimate(grid, heights.cell, options.placement_sigma_translation);
      double most = landing.estimate + 1e-4;
      for (int v = 1 - offsets.n; v < offsets.n; ++v)
        for (int u = 1 - offsets.n; u < offsets.n; ++u)
          if (grid.at(u, v).estimate > most) {
            most = grid.at(u, v).estimate;
            u_best = u;
            v_best = v;
          }
    }
    const double tilt = std::hypot(landing.a, landing.b);
    if (landing.holds && tilt < 2.0 * kLevel && robust > best.robust) {
      best.landing = landing;
      best.robust = robust;
      best.body.R_W_O = levelled(R, landing);
      best.body.p_W_M << heights.node(heights.index(offsets.i, offsets.j)), landing.height;
    }
    if (u_best == 0 && v_best == 0 && tilt < kLevel) break;
    offsets.i = std::clamp(offsets.i + u_best, -limit, limit);
    offsets.j = std::clamp(offsets.j + v_best, -limit, limit);
    R = levelled(R, u_best == 0 && v_best == 0 ? landing : Landing{});
  }
  return best;
}

}  // namespace

int half_width(std::span<const StoneGeometry> stones, double cell) {
  double radius = 0.0;
  for (const StoneGeometry& stone : stones) radius = std::max(radius, stone.radius);
  return static_cast<int>(std::ceil((radius + kOffsetReach + 0.03) / cell));
}

StackField stack_field(std::span<const BodyPose> stack, const SurfaceGrid& grid,
                       const SearchOptions& options) {
  return {top_surface(stack, grid, options.clean_height), interfaces(stack, kInterfaceTouch),
          options.friction};
}

std::vector<Proposal> propose(std::span<const BodyPose> stack, std::span<const LooseStone> stones,
                              const Eigen::Vector2d& site, int keep, const SearchOptions& options,
                              long* evaluated) {
  const bool on_table = stack.empty();
  const Eigen::Vector2d centre = on_table ? site : Eigen::Vector2d(stack.back().p_W_M.head<2>());
  double radius = 0.0;
  for (const LooseStone& stone : stones) radius = std::max(radius, stone.geometry->radius);
  const auto field_with_cell = [&](double cell) {
    const int half = static_cast<int>(std::ceil((radius + kOffsetReach + 0.03) / cell));
    return stack_field(stack, {centre, cell, half}, options);
  };
  const StackField coarse = field_with_cell(options.grid), fine = field_with_cell(0.5 * options.grid);

  struct Task {
    const LooseStone* stone;
    const Eigen::Matrix3d* R_W_O;
  };
  std::vector<Task> tasks;
  for (const LooseStone& stone : stones)
    for (const Eigen::Matrix3d& R_W_O : stone.orientations) tasks.push_back({&stone, &R_W_O});
  std::vector<std::vector<Proposal>> found(tasks.size());
  run_tasks(options.threads, tasks.size(), [&](std::size_t k) {
    found[k] = try_orientation(*tasks[k].stone, *tasks[k].R_W_O, coarse, on_table, options.yaws);
  });
  const int offsets = on_table ? 1 : static_cast<int>(std::pow(2.0 * kOffsetReach / kOffsetPitch + 1.0, 2));
  *evaluated += static_cast<long>(tasks.size()) * (on_table ? 1 : options.yaws) * offsets;

  std::vector<Proposal> candidates;
  for (const LooseStone& stone : stones) {
    std::vector<Proposal> of_stone;
    for (std::size_t k = 0; k < tasks.size(); ++k)
      if (tasks[k].stone == &stone) of_stone.insert(of_stone.end(), found[k].begin(), found[k].end());
    of_stone =
        best_distinct(std::move(of_stone), kRefined, [](const Proposal& p) { return p.landing.estimate; });
    candidates.insert(candidates.end(), of_stone.begin(), of_stone.end());
  }
  std::vector<long> counts(candidates.size(), 0);
  run_tasks(options.threads, candidates.size(), [&](std::size_t k) {
    candidates[k] = refined(candidates[k], fine, on_table, options, &counts[k]);
  });
  for (const long count : counts) *evaluated += count;

  std::vector<Proposal> result;
  for (const LooseStone& stone : stones) {
    std::vector<Proposal> of_stone;
    for (const Proposal& p : candidates)
      if (p.stone == stone.stone && p.landing.holds && p.robust > 0.0) of_stone.push_back(p);
    of_stone = best_distinct(std::move(of_stone), static_cast<std::size_t>(keep),
                             [](const Proposal& p) { return p.robust; });
    result.insert(result.end(), of_stone.begin(), of_stone.end());
  }
  return result;
}

}  // namespace stonestack
