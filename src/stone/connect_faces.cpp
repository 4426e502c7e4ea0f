#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>

#include "stone/cgal_mesh.hpp"
#include "stone/repair_mesh.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stone {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;

/// Drops all parts but the one with most faces; logs it.
void keep_largest(cgal::SurfaceMesh& surface, std::vector<std::string>& warnings) {
  const auto before = surface.number_of_faces();
  const auto dropped = pmp::keep_largest_connected_components(surface, 1);
  if (dropped == 0) return;
  warnings.push_back(concat("dropped ", dropped, " loose part", dropped == 1 ? "" : "s", " with ",
                            before - surface.number_of_faces(), " of ", before, " faces"));
}

}  // namespace

RepairedMesh connect_faces(const Mesh& mesh) {
  RepairedMesh result;
  cgal::Soup soup = cgal::to_soup(mesh);
  pmp::repair_polygon_soup(soup.points, soup.triangles);
  if (soup.triangles.size() < mesh.faces.size())
    result.warnings.push_back(concat("dropped ", mesh.faces.size() - soup.triangles.size(), " of ",
                                     mesh.faces.size(), " faces that were double or without area"));
  const std::size_t points = soup.points.size();
  if (!pmp::orient_polygon_soup(soup.points, soup.triangles))
    result.warnings.push_back(concat("split edges or corners that more than two faces share (",
                                     soup.points.size() - points, " new points)"));
  if (soup.triangles.empty() || !pmp::is_polygon_soup_a_polygon_mesh(soup.triangles)) return result;
  cgal::SurfaceMesh surface;
  pmp::polygon_soup_to_polygon_mesh(soup.points, soup.triangles, surface);
  pmp::stitch_borders(surface);
  keep_largest(surface, result.warnings);
  result.mesh = cgal::from_surface_mesh(surface);
  return result;
}

}  // namespace stonestack::stone
