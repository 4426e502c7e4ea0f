#include "search/landing.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack {
namespace {

constexpr double kActive = 0.022;       ///< m: cells further from touching are left out (measured)
constexpr double kLargestSlope = 0.2;   ///< about 11 deg of tilt (measured)
constexpr double kTouch = 0.0006;       ///< m: cells nearer than this to the resting plane carry (measured)
constexpr double kDoesNotHold = -0.25;  ///< g

Landing set_down(const StackField& stack, const Underside& underside, int i, int j, GapField* buffer) {
  lay(stack.surface, underside, i, j, kActive, buffer);
  const GapRest rest = solve_rest(*buffer, stack.surface, kLargestSlope);
  Landing landing;
  landing.holds = rest.clean;
  landing.height = rest.height;
  landing.a = rest.a;
  landing.b = rest.b;
  landing.estimate = kDoesNotHold;
  if (!rest.clean) return landing;
  const GapContact contact = contact_of(*buffer, rest, stack.surface, kTouch);
  landing.margin = contact.margin;
  landing.lever = std::max(contact.height, 1e-3);
  return landing;
}

}  // namespace

LandingGrid land(const StackField& stack, const Underside& underside, double mass, const OffsetGrid& offsets,
                 GapField* buffer) {
  LandingGrid grid{offsets, {}};
  const int n = offsets.n, width = 2 * n + 1;
  grid.landings.reserve(static_cast<std::size_t>(width * width));
  for (int v = -n; v <= n; ++v)
    for (int u = -n; u <= n; ++u)
      grid.landings.push_back(
          set_down(stack, underside, offsets.i + u * offsets.step, offsets.j + v * offsets.step, buffer));
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
  Landing landing = set_down(table, underside, 0, 0, buffer);
  if (landing.holds) landing.estimate = std::min(table.friction, landing.margin / landing.lever);
  return landing;
}

}  // namespace stonestack
