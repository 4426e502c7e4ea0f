#include "stone/mesh_deviation.hpp"

#include <cmath>

#include "core/quantile.hpp"
#include "geometry/signed_distance.hpp"
#include "geometry/surface_tree.hpp"

namespace stonestack::stone {
namespace {

Deviation summary(std::vector<double> distances) {
  if (distances.empty()) return {};
  const auto rounded = [](double metres) { return std::round(metres * 1e7) / 1e7; };  // for people to read
  return {rounded(quantile(distances, 0.5)), rounded(quantile(distances, 1.0))};
}

void add_distances(const Mesh& from, const Mesh& to, double spacing, std::vector<double>& distances) {
  const SurfaceTree tree(to);
  int face = -1;
  for (const SurfaceSample& sample : sample_surface(from, spacing)) {
    const SurfacePoint nearest = tree.nearest(sample.point, std::numeric_limits<double>::infinity(), face);
    face = nearest.face;
    distances.push_back(std::abs(nearest.distance));
  }
}

}  // namespace

Deviation deviation(const Mesh& a, const Mesh& b, double spacing) {
  std::vector<double> distances;
  add_distances(a, b, spacing, distances);
  add_distances(b, a, spacing, distances);
  return summary(std::move(distances));
}

Deviation grid_deviation(const Mesh& scan, double cell, double band, double spacing) {
  const SignedDistance grid(scan, cell, band);
  std::vector<double> distances;
  for (const SurfaceSample& sample : sample_surface(scan, spacing))
    distances.push_back(std::abs(grid.distance(sample.point)));
  return summary(std::move(distances));
}

}  // namespace stonestack::stone
