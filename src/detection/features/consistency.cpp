#include "detection/features/consistency.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace stonestack::detection {
namespace {

/// Points and normals of one correspondence, gathered for speed.
struct Pair {
  Eigen::Vector3f scene, model, scene_normal, model_normal;
};

bool consistent(const Pair& a, const Pair& b, float size, float normal) {
  const float in_scene = (a.scene - b.scene).norm(), in_model = (a.model - b.model).norm();
  // Two points nearer than the tolerance agree with anything: they are no evidence.
  if (std::abs(in_scene - in_model) > size || in_scene < size || in_model < size) return false;
  return std::abs(a.scene_normal.dot(b.scene_normal) - a.model_normal.dot(b.model_normal)) < normal;
}

/// Rigid motion of least squares, and whether it fits every pair within `size` on average.
bool rigid_fit(std::span<const Pair> pairs, std::span<const int> group, float size, Pose& T_C_O) {
  Eigen::Matrix3Xd from(3, static_cast<Eigen::Index>(group.size())), to(3, from.cols());
  for (std::size_t k = 0; k < group.size(); ++k) {
    from.col(static_cast<Eigen::Index>(k)) = pairs[static_cast<std::size_t>(group[k])].model.cast<double>();
    to.col(static_cast<Eigen::Index>(k)) = pairs[static_cast<std::size_t>(group[k])].scene.cast<double>();
  }
  T_C_O = Pose(Eigen::umeyama(from, to, false));
  const double rms = std::sqrt(((T_C_O * from) - to).colwise().squaredNorm().mean());
  if (!(rms < size)) return false;
  double agree = 0;
  for (const int i : group) {
    const auto& p = pairs[static_cast<std::size_t>(i)];
    agree += (T_C_O.linear() * p.model_normal.cast<double>()).dot(p.scene_normal.cast<double>());
  }
  return agree > 0.7 * static_cast<double>(group.size());
}

/// Which pairs are consistent, each two compared once, or as often as asked where they are very many.
class Agreement {
 public:
  Agreement(const std::vector<Pair>& pairs, float size, float normal)
      : pairs_(pairs), size_(size), normal_(normal) {
    if (pairs.size() <= kMaxPairs) known_.assign(pairs.size() * (pairs.size() + 1) / 2, kUnknown);
  }

  [[nodiscard]] bool between(std::size_t i, std::size_t k) {
    if (known_.empty()) return consistent(pairs_[i], pairs_[k], size_, normal_);
    const std::size_t low = std::min(i, k), high = std::max(i, k);
    char& known = known_[high * (high + 1) / 2 + low];
    if (known == kUnknown) known = consistent(pairs_[i], pairs_[k], size_, normal_) ? kYes : kNo;
    return known == kYes;
  }

 private:
  static constexpr std::size_t kMaxPairs = 4000;  // 8 MB
  static constexpr char kUnknown = 0, kNo = 1, kYes = 2;
  const std::vector<Pair>& pairs_;
  float size_, normal_;
  std::vector<char> known_;  ///< the lower triangle of a symmetric matrix, row by row
};

}  // namespace

std::vector<Hypothesis> consistent_groups(std::span<const Correspondence> matches, const Features& scene,
                                          const Features& model, const ConsistencyOptions& options) {
  std::vector<Pair> pairs;
  for (const auto& m : matches)
    pairs.push_back(
        {scene.points[static_cast<std::size_t>(m.scene)], model.points[static_cast<std::size_t>(m.model)],
         scene.normals[static_cast<std::size_t>(m.scene)], model.normals[static_cast<std::size_t>(m.model)]});
  const auto size = static_cast<float>(options.size), normal = static_cast<float>(options.normal_angle);
  Agreement agree(pairs, size, normal);
  std::vector<char> taken(pairs.size(), 0);
  std::vector<Hypothesis> found;
  std::vector<int> group;
  for (std::size_t seed = 0; seed < pairs.size(); ++seed) {
    if (taken[seed] != 0) continue;
    group.assign(1, static_cast<int>(seed));
    for (std::size_t j = 0; j < pairs.size(); ++j) {
      if (j == seed || taken[j] != 0) continue;
      const bool fits = std::all_of(group.begin(), group.end(),
                                    [&](int i) { return agree.between(static_cast<std::size_t>(i), j); });
      if (fits) group.push_back(static_cast<int>(j));
    }
    if (static_cast<int>(group.size()) < options.fewest) continue;
    Hypothesis h{Pose::Identity(), static_cast<double>(group.size())};
    if (!rigid_fit(pairs, group, size, h.T_C_O)) continue;
    for (const int i : group) taken[static_cast<std::size_t>(i)] = 1;
    found.push_back(h);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Hypothesis& a, const Hypothesis& b) { return a.support > b.support; });
  if (found.size() > static_cast<std::size_t>(options.best))
    found.resize(static_cast<std::size_t>(options.best));
  return found;
}

}  // namespace stonestack::detection
