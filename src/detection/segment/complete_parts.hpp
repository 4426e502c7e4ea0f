#pragma once
#include <utility>
#include <vector>

#include "detection/segment/part_tree.hpp"

namespace stonestack::detection {

/// Joins parts that belong to one object though a step divides them, and renumbers them:
/// - two parts whose surfaces continue each other behind an object in front (good continuation): along image
///   rows, columns and diagonals that leave one part, pass behind nearer surface and enter the other, most
///   tangent planes agree;
/// - the inside of a vessel and its outside: a hollow part behind a part with a level rim of its height.
void complete_parts(const ObjectSurface& surface, SurfaceParts& parts);

}  // namespace stonestack::detection
