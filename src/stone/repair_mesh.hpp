#pragma once
#include <string>
#include <vector>

#include "stonestack/geometry/mesh.hpp"

/// How a scan becomes one closed surface. Each step is a file of its own, since each is one heavy algorithm
/// of CGAL's.
namespace stonestack::stone {

/// A mesh and a sentence for each thing that was done to it beyond joining equal points.
struct RepairedMesh {
  Mesh mesh;
  std::vector<std::string> warnings;
};

/// Joins equal points, drops faces without area and double faces, orients faces alike, joins edges
/// that lie on each other, splits what is not a manifold, and keeps the largest part. May leave holes; empty
/// if nothing is left.
[[nodiscard]] RepairedMesh connect_faces(const Mesh& mesh);

/// Fills every hole with triangles about as large as their neighbours'. Unchanged without holes.
[[nodiscard]] RepairedMesh close_holes(const Mesh& mesh);

/// Pairs of faces that cut through each other.
[[nodiscard]] int count_self_intersections(const Mesh& mesh);

/// A closed surface shrunk around any heap of triangles (alpha wrapping, Portaneri et al. 2022), `offset`
/// outside of it; gaps narrower than `alpha` are bridged. Metres.
[[nodiscard]] Mesh wrap(const Mesh& mesh, double alpha, double offset);

/// Everything above in turn: one closed surface that faces outwards, with a positive volume. Throws FileError
/// named `source` when the mesh encloses nothing.
[[nodiscard]] RepairedMesh repair_mesh(const Mesh& mesh, const std::string& source);

}  // namespace stonestack::stone
