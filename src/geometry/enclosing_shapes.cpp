#include "geometry/enclosing_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/convex_pieces.hpp"

namespace stonestack::geometry {
namespace {

constexpr int kSides = 32;  // of a prism

}  // namespace

Mesh around_sphere(double radius) {
  const Mesh unit = make_sphere(1.0, 2);
  double inside = 1.0;
  const auto normals = face_normals(unit);
  for (std::size_t i = 0; i < unit.faces.size(); ++i)
    inside = std::min(inside, normals[i].dot(unit.vertices[static_cast<std::size_t>(unit.faces[i][0])]));
  return scaled(unit, radius / inside);
}

Mesh around_cylinder(double radius, double length) {
  Mesh corners;
  const double outside = radius / std::cos(std::numbers::pi / kSides);
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kSides;
    for (const double z : {-0.5 * length, 0.5 * length})
      corners.vertices.emplace_back(outside * std::cos(angle), outside * std::sin(angle), z);
  }
  return convex_hull(corners);
}

Mesh around_capsule(double radius, double length) {
  // The hull of two polyhedra that contain the spheres at the ends contains the capsule; moving only one half
  // of one polyhedron each way leaves out what lies below its middle.
  const Mesh ball = around_sphere(radius);
  Mesh both;
  for (const auto& v : ball.vertices)
    for (const double end : {-0.5, 0.5}) both.vertices.push_back(v + Eigen::Vector3d(0, 0, end * length));
  return convex_hull(both);
}

}  // namespace stonestack::geometry
