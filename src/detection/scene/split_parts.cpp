#include "detection/scene/split_parts.hpp"

#include <algorithm>
#include <cmath>

#include "detection/scene/point_grid.hpp"

namespace stonestack::detection {
namespace {

constexpr double kNearlyAll = 0.9;  // of the cluster: such a part is the cluster

/// Mean sine of the angles at which the neighbours of point `i` rise above its tangent plane.
float concavity(const PointGrid& grid, const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& p,
                const Eigen::Vector3f& normal, float radius) {
  float sum = 0;
  int count = 0;
  grid.for_each_near(p, radius, [&](int k, float d2) {
    if (d2 < 1e-10F) return;
    sum += normal.dot(points[static_cast<std::size_t>(k)] - p) / std::sqrt(d2);
    ++count;
  });
  return count > 0 ? sum / static_cast<float>(count) : 0.0F;
}

}  // namespace

std::vector<std::vector<int>> split_parts(const SurfacePoints& surface, std::span<const int> cluster,
                                          const SplitOptions& options) {
  std::vector<Eigen::Vector3f> points;
  for (const int i : cluster) points.push_back(surface.points[static_cast<std::size_t>(i)]);
  std::vector<std::vector<int>> parts;
  if (points.empty()) return parts;
  const PointGrid grid(points, static_cast<float>(options.radius));
  std::vector<Eigen::Vector3f> smooth;
  std::vector<int> index;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Eigen::Vector3f& normal = surface.normals[static_cast<std::size_t>(cluster[k])];
    if (concavity(grid, points, points[k], normal, static_cast<float>(options.radius)) >
        static_cast<float>(options.concavity))
      continue;
    smooth.push_back(points[k]);
    index.push_back(cluster[k]);
  }
  const auto label = cluster_points(smooth, static_cast<float>(options.gap), options.fewest);
  for (std::size_t k = 0; k < label.size(); ++k) {
    if (label[k] < 0) continue;
    const auto part = static_cast<std::size_t>(label[k]);
    if (parts.size() <= part) parts.resize(part + 1);
    parts[part].push_back(index[k]);
  }
  if (parts.size() == 1 &&
      static_cast<double>(parts[0].size()) > kNearlyAll * static_cast<double>(cluster.size()))
    parts.clear();
  return parts;
}

}  // namespace stonestack::detection
