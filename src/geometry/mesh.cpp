#include "stonestack/geometry/mesh.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/mesh_edges.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::geometry {
namespace {

Eigen::Vector3d corner(const Mesh& mesh, const Eigen::Vector3i& face, int k) {
  return mesh.vertices[static_cast<std::size_t>(face[k % 3])];
}

/// Twice the area, along the outward normal.
Eigen::Vector3d doubled_area(const Mesh& mesh, const Eigen::Vector3i& face) {
  const Eigen::Vector3d a = corner(mesh, face, 0);
  return (corner(mesh, face, 1) - a).cross(corner(mesh, face, 2) - a);
}

Eigen::Vector3d unit_or_zero(const Eigen::Vector3d& v) {
  const double length = v.norm();
  return length > 0.0 ? Eigen::Vector3d(v / length) : Eigen::Vector3d::Zero();
}

double angle_between(const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

}  // namespace

Eigen::AlignedBox3d bounds(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex : mesh.vertices) box.extend(vertex);
  return box;
}

double surface_area(const Mesh& mesh) {
  double sum = 0.0;
  for (const Eigen::Vector3i& face : mesh.faces) sum += doubled_area(mesh, face).norm();
  return 0.5 * sum;
}

double volume(const Mesh& mesh) {
  if (mesh.vertices.empty()) return 0.0;
  const Eigen::Vector3d middle = bounds(mesh).center();  // keeps digits when the mesh is far from the origin
  double sum = 0.0;
  for (const Eigen::Vector3i& face : mesh.faces)
    sum += (corner(mesh, face, 0) - middle).dot(doubled_area(mesh, face));
  return sum / 6.0;
}

bool is_closed(const Mesh& mesh) {
  if (mesh.faces.empty()) return false;
  const MeshEdges edges = make_mesh_edges(mesh);
  return std::all_of(edges.edges.begin(), edges.edges.end(), [](const MeshEdge& edge) {
    return edge.a != edge.b && edge.forward == 1 && edge.backward == 1;
  });
}

Mesh transformed(const Mesh& mesh, const Pose& T_B_A) {
  Mesh result = mesh;
  for (Eigen::Vector3d& vertex : result.vertices) vertex = T_B_A * vertex;
  return result;
}

Mesh scaled(const Mesh& mesh, double factor) {
  require(factor > 0.0 && std::isfinite(factor), "a mesh is scaled by a positive factor, got ", factor);
  Mesh result = mesh;
  for (Eigen::Vector3d& vertex : result.vertices) vertex *= factor;
  return result;
}

std::vector<Eigen::Vector3d> face_normals(const Mesh& mesh) {
  std::vector<Eigen::Vector3d> normals;
  normals.reserve(mesh.faces.size());
  for (const Eigen::Vector3i& face : mesh.faces) normals.push_back(unit_or_zero(doubled_area(mesh, face)));
  return normals;
}

std::vector<Eigen::Vector3d> vertex_normals(const Mesh& mesh) {
  std::vector<Eigen::Vector3d> normals(mesh.vertices.size(), Eigen::Vector3d::Zero());
  for (const Eigen::Vector3i& face : mesh.faces) {
    const Eigen::Vector3d n = unit_or_zero(doubled_area(mesh, face));
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d p = corner(mesh, face, k);
      const double angle = angle_between(corner(mesh, face, k + 1) - p, corner(mesh, face, k + 2) - p);
      normals[static_cast<std::size_t>(face[k])] += angle * n;
    }
  }
  for (Eigen::Vector3d& normal : normals) normal = unit_or_zero(normal);
  return normals;
}

}  // namespace stonestack::geometry
