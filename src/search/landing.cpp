#include "search/landing.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack::search {
namespace {

constexpr double kActive = 0.022;  ///< cells further from touching are left out (measured) [m]
constexpr double kMaxSlope = 0.2;  ///< about 11 deg of tilt (measured)
constexpr double kLandingTouch =
    0.0006;                             ///< cells nearer than this to the resting plane carry (measured) [m]
constexpr double kDoesNotHold = -0.25;  ///< [g]

/// `cells`: where the search for a rest begins, and the rest's cells.
Landing set_down(const StackField& stack, const Underside& underside, int i, int j, GapField* buffer,
                 std::array<int, 3>* cells) {
  lay(stack.surface, underside, i, j, kActive, buffer);
  const GapRest rest = solve_rest(*buffer, stack.surface, kMaxSlope, *cells);
  *cells = rest.cells;
  Landing landing;
  landing.holds = rest.clean;
  landing.height = rest.height;
  landing.a = rest.a;
  landing.b = rest.b;
  landing.estimate = kDoesNotHold;
  if (!rest.clean) return landing;
  const GapContact contact = contact_of(*buffer, rest, stack.surface, kLandingTouch);
  landing.margin = contact.margin;
  landing.lever = std::max(contact.height, 1e-3);
  return landing;
}

}  // namespace

LandingGrid land(const StackField& stack, const Underside& underside, double mass, const OffsetGrid& offsets,
                 GapField* buffer) {
  const int n = offsets.n, width = 2 * n + 1;
  LandingGrid grid{offsets, std::vector<Landing>(static_cast<std::size_t>(width * width))};
  const auto at = [&](int u, int v) { return static_cast<std::size_t>((v + n) * width + u + n); };
  std::array<int, 3> cells = kArtificial;  // each rest is sought from that of the node before
  const auto fill = [&](int u, int v) {
    grid.landings[at(u, v)] = set_down(stack, underside, offsets.i + u * offsets.step,
                                       offsets.j + v * offsets.step, buffer, &cells);
  };
  for (int v = 1 - n; v < n; ++v)
    for (int k = 1 - n; k < n; ++k) fill((v + n) % 2 == 0 ? -k : k, v);  // to and fro
  // The rim only extrapolates heights from the inner nodes that hold.
  const auto wanted = [&](int u, int v) {
    for (int y = std::max(v - 1, 1 - n); y <= std::min(v + 1, n - 1); ++y)
      for (int x = std::max(u - 1, 1 - n); x <= std::min(u + 1, n - 1); ++x)
        if (grid.at(x, y).holds) return true;
    return false;
  };
  for (int v = -n; v <= n; ++v)
    for (int u = -n; u <= n; ++u)
      if (std::max(std::abs(u), std::abs(v)) == n && wanted(u, v)) fill(u, v);
  const double pitch = offsets.step * stack.surface.heights.cell;
  for (int v = 1 - n; v < n; ++v) {
    for (int u = 1 - n; u < n; ++u) {
      Landing& landing = grid.landings[static_cast<std::size_t>((v + n) * width + u + n)];
      if (!landing.holds) continue;
      double slope = 1e300;
      for (int dv = -1; dv <= 1; ++dv)
        for (int du = -1; du <= 1; ++du)
          if (du != 0 || dv != 0)
            slope = std::min(slope, (grid.at(u + du, v + dv).height - landing.height) /
                                        (pitch * std::sqrt(static_cast<double>(du * du + dv * dv))));
      landing.slope = slope;
      const int node =
          stack.surface.heights.index(offsets.i + u * offsets.step, offsets.j + v * offsets.step);
      Eigen::Vector3d p_W_M;
      p_W_M << stack.surface.heights.node(node), landing.height;
      landing.estimate =
          std::max(kDoesNotHold, std::min({stack.friction + slope, landing.margin / landing.lever,
                                           tipping_limit(stack.interfaces, mass, p_W_M)}));
    }
  }
  return grid;
}

Landing land_on_table(const StackField& table, const Underside& underside, GapField* buffer) {
  std::array<int, 3> cells = kArtificial;
  Landing landing = set_down(table, underside, 0, 0, buffer, &cells);
  if (landing.holds) landing.estimate = std::min(table.friction, landing.margin / landing.lever);
  return landing;
}

}  // namespace stonestack::search
