#pragma once
#include <vector>

#include "stacking/believe.hpp"
#include "stonestack/stacking/observe.hpp"

/// Private to stacking/: where in the field a stone that is taken off may be set down.
namespace stonestack::stacking {

/// Poses of rest on the table, T_W_O, in which the stone lies free of the loose ones, fingers included: as it
/// would come to rest from the way it is held (`held`, in the tower), the roomiest place first; all of them
/// turned as it is held, then by a quarter about the vertical, and so on. Empty: the field has no room.
[[nodiscard]] std::vector<Pose> free_places(const ShapeList& shapes, const CellLayout& layout,
                                            const Belief& belief, const PlacedStone& held);

}  // namespace stonestack::stacking
