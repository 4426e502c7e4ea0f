#include "detection/features/matching.hpp"

#include <algorithm>

namespace stonestack::detection {

std::vector<Correspondence> match_features(const Features& scene, const Features& model, int neighbours) {
  std::vector<Correspondence> matches;
  const Eigen::Index k = std::min<Eigen::Index>(neighbours, model.descriptors.rows());
  if (scene.descriptors.rows() == 0 || k <= 0) return matches;
  const Eigen::VectorXf scene_norm = scene.descriptors.rowwise().squaredNorm();
  const Eigen::VectorXf model_norm = model.descriptors.rowwise().squaredNorm();
  const Eigen::MatrixXf product =
      model.descriptors * scene.descriptors.transpose();  // a column a scene keypoint
  std::vector<std::pair<float, int>> row(static_cast<std::size_t>(model_norm.size()));
  for (Eigen::Index s = 0; s < scene_norm.size(); ++s) {
    for (Eigen::Index m = 0; m < model_norm.size(); ++m)
      row[static_cast<std::size_t>(m)] = {model_norm(m) - 2.0F * product(m, s), static_cast<int>(m)};
    std::partial_sort(row.begin(), row.begin() + k, row.end());
    for (Eigen::Index i = 0; i < k; ++i) {
      const auto& [part, m] = row[static_cast<std::size_t>(i)];
      matches.push_back({static_cast<int>(s), m, std::max(0.0F, part + scene_norm(s))});
    }
  }
  nearest_first(matches);
  return matches;
}

void nearest_first(std::vector<Correspondence>& matches) {
  std::sort(matches.begin(), matches.end(), [](const Correspondence& a, const Correspondence& b) {
    if (a.distance != b.distance) return a.distance < b.distance;
    return a.scene != b.scene ? a.scene < b.scene : a.model < b.model;
  });
}

}  // namespace stonestack::detection
