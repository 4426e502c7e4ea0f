#pragma once
#include <span>

#include "geometry/polygon.hpp"
#include "stonestack/geometry/mesh.hpp"
#include "stonestack/geometry/pose.hpp"

namespace stonestack::geometry {

/// Convex outline of pieces seen from above, W [m].
[[nodiscard]] Polygon2 footprint(std::span<const Mesh> pieces, const Pose& T_W_object);

}  // namespace stonestack::geometry
