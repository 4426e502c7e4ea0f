#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

#include <algorithm>
#include <numeric>
#include <tuple>

#include "geometry/convex_pieces.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::geometry {
namespace {

using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;

/// The points in a fixed order, so that the hull does not depend on how they came.
std::vector<Point> sorted_points(const Mesh& mesh) {
  std::vector<Point> points;
  for (const Eigen::Vector3d& p : mesh.vertices) {
    require(p.allFinite(), "a hull needs finite points, got (", p.transpose(), ")");
    points.emplace_back(p.x(), p.y(), p.z());
  }
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

/// Vertices by coordinates, each face from its first vertex, faces in order: equal hulls are equal meshes.
Mesh in_order(const Mesh& mesh) {
  std::vector<int> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](int i) {
    const Eigen::Vector3d& p = mesh.vertices[static_cast<std::size_t>(i)];
    return std::make_tuple(p.x(), p.y(), p.z());
  };
  std::sort(order.begin(), order.end(), [&](int i, int j) { return key(i) < key(j); });
  Mesh result;
  std::vector<int> place(order.size());
  for (const int i : order) {
    place[static_cast<std::size_t>(i)] = static_cast<int>(result.vertices.size());
    result.vertices.push_back(mesh.vertices[static_cast<std::size_t>(i)]);
  }
  for (Eigen::Vector3i face : mesh.faces) {
    for (int& corner : face) corner = place[static_cast<std::size_t>(corner)];
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    result.faces.push_back(face);
  }
  std::sort(result.faces.begin(), result.faces.end(), [](const Eigen::Vector3i& f, const Eigen::Vector3i& g) {
    return std::lexicographical_compare(f.begin(), f.end(), g.begin(), g.end());
  });
  return result;
}

}  // namespace

// With exact predicates: Bullet's hull rounds points to a grid and returns near-flat faces as polygons whose
// triangles need not be convex.
Mesh convex_hull(const Mesh& mesh) {
  require(mesh.vertices.size() >= 4, "a hull needs four points, got ", mesh.vertices.size());
  const std::vector<Point> points = sorted_points(mesh);
  CGAL::Surface_mesh<Point> surface;
  CGAL::convex_hull_3(points.begin(), points.end(), surface);
  Mesh hull;
  for (const auto vertex : surface.vertices()) {
    const Point& p = surface.point(vertex);
    hull.vertices.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto face : surface.faces()) {
    Eigen::Vector3i corners;
    int k = 0;
    for (const auto vertex : surface.vertices_around_face(surface.halfedge(face)))
      if (k < 3) corners[k++] = static_cast<int>(vertex.idx());
    hull.faces.push_back(corners);
  }
  require(hull.faces.size() >= 4 && volume(hull) > 0.0, "the points lie in a plane; they have no hull");
  return in_order(hull);
}

}  // namespace stonestack::geometry
