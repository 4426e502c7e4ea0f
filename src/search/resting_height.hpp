#pragma once
#include "search/top_surface.hpp"

namespace stonestack::search {

/// The lowest height of a body's centre of mass at which it does not overlap a stack or the table, its
/// orientation and place kept. From heightmaps of 3 mm: good to some 0.2 mm.
[[nodiscard]] double resting_height(std::span<const BodyPose> stack, const BodyPose& body);

/// The pose of a stone raised or lowered to a millimetre above the first touch.
[[nodiscard]] Pose lifted_clear(const ShapeList& shapes, const Stack& stack, const PlacedStone& placed);

}  // namespace stonestack::search
