#include "modelling/smooth_seen.hpp"

#include <CGAL/Eigen_svd.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/jet_smooth_point_set.h>

#include "stonestack/core/error.hpp"

namespace stonestack::modelling {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

/// Measured on six limestones seen in three attitudes each, vertices 3 mm apart: errors of a vertex against
/// the mean within 8 mm (`bumps_mm` of bench modelling) fall from 0.32 to 0.23 mm rms with 20 neighbours;
/// with 12 to 0.24, with 30 to 0.23, with 45 to 0.26.
constexpr unsigned int kNeighbours = 20;

}  // namespace

void smooth_seen(Mesh& mesh, const std::vector<char>& seen) {
  require(seen.size() == mesh.vertices.size(), "a mesh of ", mesh.vertices.size(), " vertices, ", seen.size(),
          " with a mark");
  if (seen.size() <= kNeighbours) return;
  std::vector<Kernel::Point_3> points;
  for (const Eigen::Vector3d& p : mesh.vertices) points.emplace_back(p.x(), p.y(), p.z());
  CGAL::jet_smooth_point_set<CGAL::Sequential_tag>(points, kNeighbours,
                                                   CGAL::parameters::svd_traits(CGAL::Eigen_svd()));
  for (std::size_t v = 0; v < seen.size(); ++v)
    if (seen[v] != 0) mesh.vertices[v] = {points[v].x(), points[v].y(), points[v].z()};
}

}  // namespace stonestack::modelling
