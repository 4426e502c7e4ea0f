#include <algorithm>
#include <cmath>

#include "search/proposals.hpp"

namespace stonestack::search {
namespace {

constexpr int kRounds = 6;
constexpr double kLevel = 0.02;  ///< tilt that needs no further turning

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

/// One set-down with its neighbourhood.
struct Round {
  Landing landing;
  double robust = 0.0;
  int u = 0, v = 0;  ///< offset of the best neighbour, 0 if none is better
};

Round set_down(const StoneGeometry& stone, const Underside& underside, const StackField& stack,
               const OffsetGrid& offsets, double sigma) {
  GapField buffer;
  Round round;
  if (offsets.n == 0) {
    round.landing = land_on_table(stack, underside, &buffer);
    round.robust = round.landing.estimate;
    return round;
  }
  const LandingGrid grid = land(stack, underside, stone.mass, offsets, &buffer);
  round.landing = grid.at(0, 0);
  round.robust = robust_estimate(grid, stack.surface.heights.cell, sigma);
  double max = round.landing.estimate + 1e-4;
  for (int v = 1 - offsets.n; v < offsets.n; ++v)
    for (int u = 1 - offsets.n; u < offsets.n; ++u)
      if (grid.at(u, v).estimate > max) {
        max = grid.at(u, v).estimate;
        round.u = u;
        round.v = v;
      }
  return round;
}

}  // namespace

Refined refined(const Proposal& start, const StackField& fine, bool on_table, const SearchOptions& options) {
  Refined result{start, 0};
  Proposal& best = result.proposal;
  best.landing.holds = false;
  best.robust = -1.0;
  Eigen::Matrix3d R = levelled(start.body.R_W_O, start.landing);
  const HeightRaster& heights = fine.surface.heights;
  const Eigen::Vector2d from = (start.body.p_W_M.head<2>() - heights.centre) / heights.cell;
  OffsetGrid offsets;
  offsets.i = static_cast<int>(std::lround(from.x()));
  offsets.j = static_cast<int>(std::lround(from.y()));
  offsets.n = on_table ? 0 : 3;
  offsets.step = 1;
  const int limit = static_cast<int>(std::ceil((kOffsetReach + 0.01) / heights.cell)) - offsets.n;
  const StoneGeometry& stone = *start.body.stone;
  const auto underside_at = [&](const Eigen::Matrix3d& R_W_O) {
    return make_underside(stone.vertices_M, stone.faces, R_W_O, underside_options(fine));
  };
  Underside underside = underside_at(R);
  for (int k = 0; k < kRounds; ++k) {
    const Round round = set_down(stone, underside, fine, offsets, options.placement_sigma_translation);
    result.evaluated += static_cast<long>((2 * offsets.n + 1) * (2 * offsets.n + 1));
    const double tilt = std::hypot(round.landing.a, round.landing.b);
    if (round.landing.holds && tilt < 2.0 * kLevel && round.robust > best.robust) {
      best.landing = round.landing;
      best.robust = round.robust;
      best.body.R_W_O = levelled(R, round.landing);
      best.body.p_W_M << heights.node(heights.index(offsets.i, offsets.j)), round.landing.height;
    }
    const bool moved = round.u != 0 || round.v != 0;
    if (!moved && tilt < kLevel) break;
    if (moved) {
      offsets.i = std::clamp(offsets.i + round.u, -limit, limit);
      offsets.j = std::clamp(offsets.j + round.v, -limit, limit);
    } else {
      R = levelled(R, round.landing);
      underside = underside_at(R);
    }
  }
  return result;
}

}  // namespace stonestack::search
