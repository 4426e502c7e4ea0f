#pragma once
#include "stonestack/stone/stone.hpp"

namespace stonestack::stone {

/// The stone as it may be, as well as its surface is known: each vertex of its scan is displaced along its
/// normal by a smooth random field (Gaussian, correlated over 15 mm) times its standard deviation, but not
/// into a table that the stone lay on. The mass stays; centre of mass and inertia change as those of the
/// surface do, with even density. Nothing else is changed, and nothing at all without `Stone::surface`.
/// @param draw number of the draw; the same gives the same stone
[[nodiscard]] Stone possible_stone(Stone stone, int draw);

}  // namespace stonestack::stone
