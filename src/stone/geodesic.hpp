#pragma once
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::stone {

/// Unit sphere as an icosahedron whose edges are cut into `frequency` parts: 20 * frequency^2 nearly equal
/// faces, any frequency (`make_sphere` has only powers of four).
[[nodiscard]] Mesh make_geodesic(int frequency);

}  // namespace stonestack::stone
