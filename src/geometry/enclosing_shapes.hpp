#pragma once
#include "stonestack/geometry/mesh.hpp"

/// Private: convex polyhedra that contain round shapes, centred on the origin, as tightly as few faces allow.
/// What keeps clear of them keeps clear of the shapes.
namespace stonestack::geometry {

/// A polyhedron of 320 faces around a sphere. `radius` in m, positive; so below.
[[nodiscard]] Mesh around_sphere(double radius);
/// A prism of 32 sides around a cylinder about z.
[[nodiscard]] Mesh around_cylinder(double radius, double length);
/// `length` is between the centres of the two half spheres, along z.
[[nodiscard]] Mesh around_capsule(double radius, double length);

}  // namespace stonestack::geometry
