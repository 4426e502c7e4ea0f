#pragma once
#include <Eigen/Geometry>
#include <vector>

#include "stonestack/geometry/pose.hpp"

#pragma GCC visibility push(default)

namespace stonestack::geometry {

/// Triangles over shared vertices, metres unless a name says otherwise; faces counter-clockwise seen from
/// outside.
struct Mesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> faces;
};

[[nodiscard]] Eigen::AlignedBox3d bounds(const Mesh& mesh);
/// [m^2]
[[nodiscard]] double surface_area(const Mesh& mesh);
/// Signed (divergence theorem); positive when faces point outwards. m^3.
[[nodiscard]] double volume(const Mesh& mesh);
/// True if every edge has exactly two faces with opposite directions.
[[nodiscard]] bool is_closed(const Mesh& mesh);
[[nodiscard]] Mesh transformed(const Mesh& mesh, const Pose& T_B_A);
[[nodiscard]] Mesh scaled(const Mesh& mesh, double factor);
/// Unit outward normal of each face; zero for a degenerate face.
[[nodiscard]] std::vector<Eigen::Vector3d> face_normals(const Mesh& mesh);
/// Angle-weighted unit normal of each vertex.
[[nodiscard]] std::vector<Eigen::Vector3d> vertex_normals(const Mesh& mesh);
/// Axis-aligned box centred at the origin, 12 faces. For tests and simple scenes.
[[nodiscard]] Mesh make_box(const Eigen::Vector3d& size);
/// Geodesic sphere with `subdivisions` 4-to-1 splits of an icosahedron (20 * 4^n faces).
[[nodiscard]] Mesh make_sphere(double radius, int subdivisions);

/// A point on a surface with its outward normal and the surface area that it stands for.
struct SurfaceSample {
  Eigen::Vector3d point;
  Eigen::Vector3d normal;
  double area = 0.0;  ///< [m^2]
};
/// Samples a surface: every vertex, points along edges and inside faces so that neighbours are at most about
/// `spacing` apart. Deterministic; areas sum to the surface area.
[[nodiscard]] std::vector<SurfaceSample> sample_surface(const Mesh& mesh, double spacing);

}  // namespace stonestack::geometry

#pragma GCC visibility pop
