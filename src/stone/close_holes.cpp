#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>

#include <iomanip>
#include <sstream>

#include "stone/cgal_mesh.hpp"
#include "stone/repair_mesh.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stone {

RepairedMesh close_holes(const Mesh& mesh) {
  namespace pmp = CGAL::Polygon_mesh_processing;
  RepairedMesh result;
  cgal::SurfaceMesh surface = cgal::to_surface_mesh(mesh);
  std::vector<cgal::SurfaceMesh::Halfedge_index> holes;
  pmp::extract_boundary_cycles(surface, std::back_inserter(holes));
  if (holes.empty()) {
    result.mesh = mesh;
    return result;
  }
  const double before = surface_area(mesh);
  for (const auto hole : holes) {
    throw_if_interrupted();
    std::vector<cgal::SurfaceMesh::Face_index> faces;
    std::vector<cgal::SurfaceMesh::Vertex_index> vertices;
    pmp::triangulate_and_refine_hole(surface, hole, std::back_inserter(faces), std::back_inserter(vertices));
  }
  result.mesh = cgal::from_surface_mesh(surface);
  const double added = surface_area(result.mesh) - before;
  std::ostringstream share;
  share << std::fixed << std::setprecision(1) << 100.0 * added / (added + before);
  result.warnings.push_back(concat("closed ", holes.size(), holes.size() == 1 ? " hole" : " holes", ", ",
                                   share.str(), " % of the surface: this part of the stone was never seen"));
  return result;
}

}  // namespace stonestack::stone
