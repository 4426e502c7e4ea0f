#pragma once
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::stone {

/// A closed mesh with at most `faces` faces: edges collapse where that moves the surface least (Garland and
/// Heckbert 1997), with a bound on how far normals turn. The mesh itself if it is small enough. Closed meshes
/// stay closed. Returns an empty mesh when the faces make no manifold or the number is out of reach.
[[nodiscard]] Mesh reduce_mesh(const Mesh& mesh, int faces);

}  // namespace stonestack::stone
