#include "geometry/mesh_edges.hpp"

#include <algorithm>
#include <tuple>

namespace stonestack::geometry {
namespace {

struct HalfEdge {
  int a, b, face, corner;
  bool forward;
};

std::vector<HalfEdge> half_edges(const Mesh& mesh) {
  std::vector<HalfEdge> halves;
  halves.reserve(3 * mesh.faces.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int from = mesh.faces[f][k];
      const int to = mesh.faces[f][(k + 1) % 3];
      halves.push_back({std::min(from, to), std::max(from, to), static_cast<int>(f), k, from < to});
    }
  }
  std::sort(halves.begin(), halves.end(), [](const HalfEdge& x, const HalfEdge& y) {
    return std::tie(x.a, x.b, x.face, x.corner) < std::tie(y.a, y.b, y.face, y.corner);
  });
  return halves;
}

}  // namespace

MeshEdges make_mesh_edges(const Mesh& mesh) {
  const std::vector<Eigen::Vector3d> normals = face_normals(mesh);
  MeshEdges result;
  result.of_face.resize(mesh.faces.size());
  for (const HalfEdge& half : half_edges(mesh)) {
    if (result.edges.empty() || result.edges.back().a != half.a || result.edges.back().b != half.b)
      result.edges.push_back({half.a, half.b});
    MeshEdge& edge = result.edges.back();
    ++(half.forward ? edge.forward : edge.backward);
    edge.normal += normals[static_cast<std::size_t>(half.face)];
    result.of_face[static_cast<std::size_t>(half.face)][static_cast<std::size_t>(half.corner)] =
        static_cast<int>(result.edges.size()) - 1;
  }
  for (MeshEdge& edge : result.edges) edge.normal.normalize();
  return result;
}

}  // namespace stonestack::geometry
