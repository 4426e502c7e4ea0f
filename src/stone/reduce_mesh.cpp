#include "stone/reduce_mesh.hpp"

#include "stone/cgal_mesh.hpp"

#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_placement.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_plane_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include "stonestack/core/error.hpp"

namespace stonestack::stone {
namespace {

namespace sms = CGAL::Surface_mesh_simplification;
using Policies = sms::GarlandHeckbert_plane_policies<cgal::SurfaceMesh, cgal::Kernel>;
using Placement = sms::Bounded_normal_change_placement<Policies::Get_placement>;

void collapse(cgal::SurfaceMesh& surface, std::size_t edges) {
  const Policies policies(surface);
  const sms::Count_stop_predicate<cgal::SurfaceMesh> stop(edges);
  sms::edge_collapse(
      surface, stop,
      CGAL::parameters::get_cost(policies.get_cost()).get_placement(Placement(policies.get_placement())));
}

}  // namespace

Mesh reduce_mesh(const Mesh& mesh, int faces) {
  require(faces >= 4, "a closed mesh has at least 4 faces, got ", faces);
  if (mesh.faces.size() <= static_cast<std::size_t>(faces)) return mesh;
  cgal::SurfaceMesh surface = cgal::to_surface_mesh(mesh);
  // A closed mesh has an even number of faces and three edges for two; the predicate stops below its number.
  collapse(surface, static_cast<std::size_t>(faces / 2) * 3 + 1);
  Mesh result = cgal::from_surface_mesh(surface);
  return result.faces.size() <= static_cast<std::size_t>(faces) ? result : Mesh{};
}

}  // namespace stonestack::stone
