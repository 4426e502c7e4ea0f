#pragma once
#include <vector>

#include "search/top_surface.hpp"

namespace stonestack::search {

/// A stack as the gap field sees it.
struct StackField {
  TopSurface surface;
  std::vector<Interface> interfaces;
  double friction = 0.1;
};

/// One orientation of a stone set down over one node of a stack's top.
struct Landing {
  bool holds = false;       ///< rests on three points around its centre of mass, all on the top stone
  double height = 0.0;      ///< of the centre of mass, W [m]
  double a = 0.0, b = 0.0;  ///< tilt still needed
  double margin = 0.0;      ///< centre of mass to the rim of the contacts [m]
  double lever = 0.0;       ///< centre of mass over the contacts [m]
  double slope = 0.0;       ///< rise of the centre of mass over sideways distance, least of eight directions
  double estimate = -1.0;   ///< horizontal acceleration that it should bear [g]
};

/// A square of offsets of the centre of mass around a node: (2 n + 1)^2, `step` nodes apart. The rim has no
/// slope and no estimate.
struct OffsetGrid {
  int i = 0, j = 0;  ///< node of the middle
  int n = 4;
  int step = 2;
};
struct LandingGrid {
  OffsetGrid offsets;
  std::vector<Landing> landings;  ///< row by row

  [[nodiscard]] const Landing& at(int u, int v) const {
    return landings[static_cast<std::size_t>((v + offsets.n) * (2 * offsets.n + 1) + u + offsets.n)];
  }
};
/// Estimate: the least of friction + slope (sliding out of the cradle), margin / lever (tipping over the
/// contacts) and the tipping limits of the interfaces below; -0.25 where it does not hold.
[[nodiscard]] LandingGrid land(const StackField& stack, const Underside& underside, double mass,
                               const OffsetGrid& offsets, GapField* buffer);
/// On the table, where every offset is alike.
[[nodiscard]] Landing land_on_table(const StackField& table, const Underside& underside, GapField* buffer);

}  // namespace stonestack::search
