#pragma once
#include <vector>

#include "stacking/arrangement.hpp"
#include "stonestack/stacking/observe.hpp"

/// Private to stacking/: where in the field a stone may be set down.
namespace stonestack::stacking {

/// Poses on the table, T_W_O, in which the stone lies clear of the loose ones, fingers included: as it would
/// come to rest from how it is held (`held`, in the tower), the place with the most clearance first; all of
/// them with the yaw that it has in the gripper, then turned by a quarter about the vertical, and so on.
/// Then, if it would roll to rest, the same places as it is held, 2 mm above the table: a gripper that held
/// it there may not fit between the resting stone and the table. Empty: no place in the field is free.
[[nodiscard]] std::vector<Pose> free_places(const ShapeList& shapes, const CellLayout& layout,
                                            const Arrangement& arrangement, const PlacedStone& held);

}  // namespace stonestack::stacking
