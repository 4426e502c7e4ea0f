#pragma once
#include <vector>

#include "stonestack/geometry/mesh.hpp"

namespace stonestack::modelling {

/// Takes the noise of the camera's pixels out of a fused surface: each vertex that was seen is put on the
/// quadric through its nearest vertices (moving least squares; CGAL's jet smoothing). Fused depth errs from
/// vertex to vertex by more than stones are rough, and a model that rests on such bumps rests otherwise than
/// the stone.
/// @param seen a vertex each, 0 where it was completed: those stay
void smooth_seen(Mesh& mesh, const std::vector<char>& seen);

}  // namespace stonestack::modelling
