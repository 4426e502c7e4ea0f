#pragma once
#include <vector>

#include "search/proposals.hpp"
#include "search/search_context.hpp"

namespace stonestack::search {

/// How a flat plate would lie on top of a stone: what the next course finds.
struct TopFace {
  double height = 0.0;                                  ///< of the plate over the centre of mass [m]
  double margin = 0.0;                                  ///< centre of mass to the rim of what carries it [m]
  Eigen::Vector3d normal_O = Eigen::Vector3d::UnitZ();  ///< of the plate
};
/// Extents of a stone about its centre of mass [m].
struct Extents {
  Eigen::Vector2d min, max;
};
[[nodiscard]] Extents extents_of(const StoneGeometry& stone, const Eigen::Matrix3d& R_W_O);

/// A side of a stone that may point down, in one turn about the vertical.
struct WallSide {
  Eigen::Matrix3d R_W_O;  ///< levelled on a table
  Landing on_table;       ///< how it lies there
  TopFace top;            ///< what it then offers
  Extents extents;        ///< along the wall (x) and across it (y)
  double outline = 0.0;   ///< area of the convex hull, seen from above [m^2]
  Underside underside;    ///< for rasters of the stride that it was made for
};
/// A loose stone with its sides.
struct WallStone {
  StoneIndex stone = kNoStone;
  const StoneGeometry* geometry = nullptr;
  std::vector<WallSide> sides;
};
/// Sides on which the stones lie firmly and level and whose top carries a plate, in `yaws` turns each.
/// @param stride of the rasters that undersides are laid over; `options.grid` is their cell.
[[nodiscard]] std::vector<WallStone> wall_stones(const SearchContext& context, int stride);

/// A side of a stone that stands already: `on_table` and `underside` are empty. A top that carries no plate
/// is as high as its highest point and carries nothing.
[[nodiscard]] WallSide standing_side(const SearchContext& context, const StoneGeometry& stone,
                                     const Eigen::Matrix3d& R_W_O);

/// Half width, in nodes, of the raster about a place in the wall for any of the stones.
[[nodiscard]] int raster_half(const SearchContext& context, double cell);

}  // namespace stonestack::search
