#include "modelling/surface_of_volume.hpp"

#include <CGAL/Complex_2_in_triangulation_3.h>
#include <CGAL/IO/facets_in_complex_2_to_triangle_mesh.h>
#include <CGAL/Implicit_surface_3.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_default_triangulation_3.h>
#include <CGAL/make_surface_mesh.h>

#include <functional>

#include "stonestack/core/error.hpp"

namespace stonestack::modelling {
namespace {

using Triangulation = CGAL::Surface_mesh_default_triangulation_3;
using Complex = CGAL::Complex_2_in_triangulation_3<Triangulation>;
using Traits = Triangulation::Geom_traits;
using Surface = CGAL::Implicit_surface_3<Traits, std::function<double(Traits::Point_3)>>;

constexpr double kMinAngle = 25.0;   // degrees of a triangle
constexpr double kOffSurface = 0.1;  // of `facet`: distance of a triangle's middle from the surface
constexpr double kPrecision = 1e-4;  // of the sphere's radius, with which the surface is met

}  // namespace

Mesh surface_of(const DistanceVolume& volume, double facet) {
  const Eigen::Vector3d inside = volume.deepest();
  require(volume.distance(inside) < 0.0, "nothing is inside the volume");
  double reach = 0.0;
  for (int corner = 0; corner < 8; ++corner)
    reach = std::max(
        reach, (volume.box().corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)) - inside).norm());
  const auto distance = [&](const Traits::Point_3& p) { return volume.distance({p.x(), p.y(), p.z()}); };
  const Traits::Point_3 centre(inside.x(), inside.y(), inside.z());
  const double radius = reach + facet;
  Triangulation triangulation;
  Complex complex(triangulation);
  const Surface surface(distance, Traits::Sphere_3(centre, radius * radius), kPrecision);
  const CGAL::Surface_mesh_default_criteria_3<Triangulation> criteria(kMinAngle, facet, kOffSurface * facet);
  CGAL::make_surface_mesh(complex, surface, criteria, CGAL::Manifold_tag());
  CGAL::Surface_mesh<Traits::Point_3> found;
  CGAL::facets_in_complex_2_to_triangle_mesh(complex, found);
  Mesh mesh;
  for (const auto vertex : found.vertices()) {
    const auto& p = found.point(vertex);
    mesh.vertices.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto face : found.faces()) {
    Eigen::Vector3i corners = Eigen::Vector3i::Zero();
    int k = 0;
    for (const auto vertex : found.vertices_around_face(found.halfedge(face)))
      corners[k++ % 3] = static_cast<int>(vertex.idx());
    mesh.faces.push_back(corners);
  }
  if (geometry::volume(mesh) < 0.0)
    for (auto& face : mesh.faces) std::swap(face[1], face[2]);
  return mesh;
}

}  // namespace stonestack::modelling
