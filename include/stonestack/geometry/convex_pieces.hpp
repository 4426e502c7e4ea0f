#pragma once
#include <vector>

#include "stonestack/geometry/mesh.hpp"

#pragma GCC visibility push(default)

namespace stonestack::geometry {

/// Options of `convex_pieces`.
struct ConvexPiecesOptions {
  int max_pieces = 5;       ///< pieces; coarser until it fits (measured: more are 3 to 4 times slower)
  int max_vertices = 64;    ///< vertices a piece
  double concavity = 30.0;  ///< HACD's concavity to start from, of 1000
};

/// Approximate convex decomposition (HACD, from Bullet's extras): closed convex meshes that together cover
/// the stone. Coarse (0.5 to 1.4 mm median off the scan): for proposals and collision checks, never for a
/// verdict.
[[nodiscard]] std::vector<Mesh> convex_pieces(const Mesh& mesh, const ConvexPiecesOptions& options = {});
/// Convex hull as a closed mesh.
[[nodiscard]] Mesh convex_hull(const Mesh& mesh);

}  // namespace stonestack::geometry

#pragma GCC visibility pop
