#pragma once
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include <array>
#include <vector>

#include "stonestack/geometry/mesh.hpp"

/// CGAL's mesh types and conversions to and from them.
namespace stonestack::stone::cgal {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using SurfaceMesh = CGAL::Surface_mesh<Point>;

/// Triangles without any connection, as a scanner may deliver them.
struct Soup {
  std::vector<Point> points;
  std::vector<std::vector<std::size_t>> triangles;
};

[[nodiscard]] inline Soup to_soup(const Mesh& mesh) {
  Soup soup;
  for (const Eigen::Vector3d& v : mesh.vertices) soup.points.emplace_back(v.x(), v.y(), v.z());
  for (const Eigen::Vector3i& face : mesh.faces)
    soup.triangles.push_back({static_cast<std::size_t>(face[0]), static_cast<std::size_t>(face[1]),
                              static_cast<std::size_t>(face[2])});
  return soup;
}

/// The faces must make a manifold, with a border or without; returns an empty mesh if they do not.
[[nodiscard]] inline SurfaceMesh to_surface_mesh(const Mesh& mesh) {
  SurfaceMesh result;
  for (const Eigen::Vector3d& v : mesh.vertices) result.add_vertex(Point(v.x(), v.y(), v.z()));
  using Vertex = SurfaceMesh::Vertex_index;
  for (const Eigen::Vector3i& face : mesh.faces) {
    const auto added =
        result.add_face(Vertex(static_cast<unsigned>(face[0])), Vertex(static_cast<unsigned>(face[1])),
                        Vertex(static_cast<unsigned>(face[2])));
    if (added == SurfaceMesh::null_face()) return {};
  }
  return result;
}

/// Vertices and faces in the order of their indices.
[[nodiscard]] inline Mesh from_surface_mesh(SurfaceMesh& surface) {
  surface.collect_garbage();
  Mesh mesh;
  for (const auto vertex : surface.vertices()) {
    const Point& p = surface.point(vertex);
    mesh.vertices.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto face : surface.faces()) {
    Eigen::Vector3i corners;
    int k = 0;
    for (const auto vertex : surface.vertices_around_face(surface.halfedge(face)))
      corners[k++ % 3] = static_cast<int>(vertex.idx());
    mesh.faces.push_back(corners);
  }
  return mesh;
}

}  // namespace stonestack::stone::cgal
