#include "detection/features/descriptors.hpp"

namespace stonestack::detection {

Features finite_features(const SurfacePoints& surface, std::span<const int> keypoints,
                         const Eigen::MatrixXf& rows) {
  Features out;
  std::vector<Eigen::Index> kept;
  for (std::size_t k = 0; k < keypoints.size(); ++k) {
    if (!rows.row(static_cast<Eigen::Index>(k)).allFinite()) continue;
    kept.push_back(static_cast<Eigen::Index>(k));
    out.points.push_back(surface.points[static_cast<std::size_t>(keypoints[k])]);
    out.normals.push_back(surface.normals[static_cast<std::size_t>(keypoints[k])]);
  }
  out.descriptors = rows(kept, Eigen::all);
  return out;
}

}  // namespace stonestack::detection
