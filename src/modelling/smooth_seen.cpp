#include "modelling/smooth_seen.hpp"

#include <CGAL/Eigen_svd.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/jet_smooth_point_set.h>

#include "stonestack/core/error.hpp"

namespace stonestack::modelling {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

/// Measured on 12 limestones of 3 attitudes (bench modelling's views): errors against the mean within 8 mm
/// fall from 0.33 to 0.23 mm rms with 20 neighbours; 12: 0.25, 30: 0.24, 45: 0.26.
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
