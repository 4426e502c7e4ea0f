#include <CGAL/Polygon_mesh_processing/self_intersections.h>

#include "stone/cgal_mesh.hpp"
#include "stone/repair_mesh.hpp"

namespace stonestack::stone {

int count_self_intersections(const Mesh& mesh) {
  const cgal::SurfaceMesh surface = cgal::to_surface_mesh(mesh);
  using Face = cgal::SurfaceMesh::Face_index;
  std::vector<std::pair<Face, Face>> pairs;
  CGAL::Polygon_mesh_processing::self_intersections(surface, std::back_inserter(pairs));
  return static_cast<int>(pairs.size());
}

}  // namespace stonestack::stone
