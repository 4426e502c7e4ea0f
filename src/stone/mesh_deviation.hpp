#pragma once
#include "stonestack/stone/stone.hpp"

namespace stonestack::stone {

/// Deviation between two surfaces, in both directions: points of each, `spacing` apart, to the nearest point
/// of the other.
[[nodiscard]] Deviation deviation(const Mesh& a, const Mesh& b, double spacing);
/// Between a surface and what a signed distance on a grid of `cell` makes of it, which is what physics
/// collides with: the grid's distance at points of the surface, where it should be zero.
[[nodiscard]] Deviation grid_deviation(const Mesh& scan, double cell, double band, double spacing);

}  // namespace stonestack::stone
