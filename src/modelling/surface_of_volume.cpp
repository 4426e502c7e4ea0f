#include "modelling/surface_of_volume.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Labeled_mesh_domain_3.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/facets_in_complex_3_to_triangle_mesh.h>
#include <CGAL/refine_mesh_3.h>

#include <functional>
#include <iterator>
#include <utility>
#include <vector>

namespace stonestack::modelling {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Domain = CGAL::Labeled_mesh_domain_3<Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

constexpr double kMinAngle = 25.0;   // degrees of a triangle
constexpr double kOffSurface = 0.1;  // of `facet`: distance of a triangle's middle from the surface
constexpr int kFirstPoints = 100;    // on the surface, with which meshing begins
constexpr double kPrecision = 1e-4;  // of the sphere's radius, with which the surface is met

}  // namespace

Mesh surface_of(const DistanceVolume& volume, double facet) {
  const Eigen::Vector3d inside = volume.deepest();
  if (!(volume.distance(inside) < 0.0)) return {};
  double reach = 0.0;
  for (int corner = 0; corner < 8; ++corner)
    reach = std::max(
        reach, (volume.box().corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)) - inside).norm());
  const auto distance = [&](const Kernel::Point_3& p) { return volume.distance({p.x(), p.y(), p.z()}); };
  const Kernel::Point_3 centre(inside.x(), inside.y(), inside.z());
  const double radius = reach + facet;
  namespace with = CGAL::parameters;
  const Domain domain = Domain::create_implicit_mesh_domain(
      distance, Kernel::Sphere_3(centre, radius * radius), with::relative_error_bound = kPrecision);
  const Criteria criteria(with::facet_angle = kMinAngle, with::facet_size = facet,
                          with::facet_distance = kOffSurface * facet);
  // Of the usual twelve first points on a compact stone's surface now and then no triangle lies on it, and
  // nothing is there to refine.
  std::vector<std::pair<Kernel::Point_3, Domain::Index>> first;
  domain.construct_initial_points_object()(std::back_inserter(first), kFirstPoints);
  Complex complex;
  for (const auto& [point, index] : first) {
    const auto vertex = complex.triangulation().insert(Triangulation::Weighted_point(point));
    if (vertex == Complex::Vertex_handle()) continue;  // hidden by another
    complex.set_dimension(vertex, 2);
    complex.set_index(vertex, index);
  }
  CGAL::refine_mesh_3(complex, domain, criteria, with::manifold(), with::no_perturb(), with::no_exude(),
                      with::no_odt(), with::no_lloyd());
  CGAL::Surface_mesh<Kernel::Point_3> found;
  CGAL::facets_in_complex_3_to_triangle_mesh(complex, found);
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
