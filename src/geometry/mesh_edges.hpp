#pragma once
#include <array>
#include <vector>

#include "stonestack/geometry/mesh.hpp"

namespace stonestack::geometry {

/// An undirected edge of a mesh, a < b.
struct MeshEdge {
  int a = 0;
  int b = 0;
  int forward = 0;                                   ///< faces that run it from a to b
  int backward = 0;                                  ///< faces that run it from b to a
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< sum of the unit normals of its faces, then unit
};

/// The edges of a mesh, sorted by (a, b), and where each face finds its own.
struct MeshEdges {
  std::vector<MeshEdge> edges;
  std::vector<std::array<int, 3>> of_face;  ///< edge k of a face runs from its corner k to corner k + 1
};

[[nodiscard]] MeshEdges make_mesh_edges(const Mesh& mesh);

}  // namespace stonestack::geometry
