#pragma once
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "stonestack/geometry/pose.hpp"

#pragma GCC visibility push(default)

namespace stonestack::geometry {

/// Triangles over shared vertices, metres unless a name states another unit; faces counter-clockwise seen
/// from outside.
struct Mesh {
  std::vector<Eigen::Vector3d> vertices;  ///< corners [m]
  std::vector<Eigen::Vector3i> faces;     ///< triangles: indices of their corners
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
  Eigen::Vector3d point;   ///< point on the surface [m]
  Eigen::Vector3d normal;  ///< unit normal of the surface, outwards
  double area = 0.0;       ///< [m^2]
};
/// Samples a surface: every vertex, points along edges and inside faces so that neighbours are at most about
/// `spacing` apart. Deterministic; areas sum to the surface area.
[[nodiscard]] std::vector<SurfaceSample> sample_surface(const Mesh& mesh, double spacing);

/// Reads PLY, OBJ and STL with strict readers of our own (counts checked before allocation, indices and
/// finiteness checked, no second file opened). Exactly equal vertices become one (texture seams and STL
/// repeat them), then faces with a repeated corner and vertices without a face are dropped. Coordinates are
/// as in the file: no unit is applied. glTF (.glb, .gltf), Collada (.dae, in metres by its own unit), 3DS,
/// OFF and FBX are read by assimp in a process of its own with limits, which opens no second file either;
/// their nodes' transformations are applied.
/// @throws FileError also for other formats.
[[nodiscard]] Mesh read_mesh(const std::string& path);
/// Binary little-endian PLY, or OBJ, by extension; atomic.
/// @throws FileError
void write_mesh(const std::string& path, const Mesh& mesh);

/// Mass, centre of mass and inertia of a rigid body, in the frame of its mesh (O).
struct MassProperties {
  double mass = 0.0;                                ///< [kg]
  Eigen::Vector3d p_O_M = Eigen::Vector3d::Zero();  ///< centre of mass, m
  Eigen::Matrix3d I_M = Eigen::Matrix3d::Zero();    ///< about the centre of mass, axes of O, kg m^2
};

/// Of a closed mesh of uniform `density` (kg/m^3), exact for polyhedra (Mirtich 1996).
/// @throws InvalidArgument when the volume is not positive.
[[nodiscard]] MassProperties mass_properties(const Mesh& mesh, double density);
/// Empty if physically possible; else what is wrong: mass not positive, inertia not positive definite or
/// against the triangle inequality, not finite.
[[nodiscard]] std::string check(const MassProperties& properties);

}  // namespace stonestack::geometry

#pragma GCC visibility pop
