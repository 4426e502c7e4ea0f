#include <array>
#include <cmath>
#include <map>

#include "stonestack/core/error.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::geometry {
namespace {

Mesh make_icosahedron() {
  const double g = 0.5 * (1.0 + std::sqrt(5.0));
  Mesh mesh;
  mesh.vertices = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                   {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  mesh.faces = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex.normalize();
  return mesh;
}

/// Splits each face in four; new vertices lie on the unit sphere.
Mesh subdivided(const Mesh& mesh) {
  Mesh result;
  result.vertices = mesh.vertices;
  std::map<std::array<int, 2>, int> middle_of;
  auto middle = [&](int a, int b) {
    const auto [entry, is_new] =
        middle_of.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<int>(result.vertices.size()));
    if (is_new) {
      const auto i = static_cast<std::size_t>(a);
      const auto j = static_cast<std::size_t>(b);
      result.vertices.emplace_back((mesh.vertices[i] + mesh.vertices[j]).normalized());
    }
    return entry->second;
  };
  for (const Eigen::Vector3i& f : mesh.faces) {
    const Eigen::Vector3i m(middle(f[0], f[1]), middle(f[1], f[2]), middle(f[2], f[0]));
    result.faces.emplace_back(f[0], m[0], m[2]);
    result.faces.emplace_back(f[1], m[1], m[0]);
    result.faces.emplace_back(f[2], m[2], m[1]);
    result.faces.push_back(m);
  }
  return result;
}

}  // namespace

Mesh make_box(const Eigen::Vector3d& size) {
  require(size.allFinite() && size.minCoeff() > 0.0, "a box needs three positive sides, got ",
          size.transpose(), " m");
  Mesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d side(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
    mesh.vertices.emplace_back(side.cwiseProduct(size));
  }
  mesh.faces = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

Mesh make_sphere(double radius, int subdivisions) {
  require(radius > 0.0 && std::isfinite(radius), "a sphere needs a positive radius, got ", radius, " m");
  require(subdivisions >= 0 && subdivisions <= 8, "a sphere takes 0 to 8 subdivisions, got ", subdivisions);
  Mesh mesh = make_icosahedron();
  for (int i = 0; i < subdivisions; ++i) mesh = subdivided(mesh);
  return scaled(mesh, radius);
}

}  // namespace stonestack::geometry
