#include <CGAL/alpha_wrap_3.h>

#include "stone/cgal_mesh.hpp"
#include "stone/repair_mesh.hpp"

namespace stonestack::stone {

Mesh wrap(const Mesh& mesh, double alpha, double offset) {
  const cgal::Soup soup = cgal::to_soup(mesh);
  cgal::SurfaceMesh surface;
  CGAL::alpha_wrap_3(soup.points, soup.triangles, alpha, offset, surface);
  return cgal::from_surface_mesh(surface);
}

}  // namespace stonestack::stone
