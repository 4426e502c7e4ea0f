#include "detection/accept.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace stonestack {
namespace {

constexpr double kLeastVisible = 0.04;    // of the whole surface: less is no evidence
constexpr double kMuchVisible = 0.13;     // of the whole surface: less must fit the better ...
constexpr double kLittleVisible = 1.5;    // ... by this much score for all that is missing (bench: hidden)
constexpr double kUsuallyLacking = 0.03;  // of the score of a right pose
constexpr double kLargestOverlap = 0.3;   // of a candidate's pixels that an accepted one explains already

/// Score first, by what it lacks: 0.99 against 0.96 says more than 0.93 against 0.90. But a large surface
/// that fits is worth more than a small one. The paper has the inlier ratio.
double worth(const Candidate& c, const DetectionOptions& options) {
  if (options.method == "paper") return c.detection.inlier_ratio;
  const double lacking = 1.0 - c.detection.score + kUsuallyLacking;
  return c.detection.score / lacking * std::sqrt(static_cast<double>(c.pixels.size()));
}

/// Pixels that accepted candidates explain, in every view.
class Claims {
 public:
  explicit Claims(const DetectionScene& scene) : scene_(scene) {
    for (const auto& view : scene.views) claimed_.emplace_back(view.depth.z.size(), 0);
  }

  [[nodiscard]] double overlap(const Candidate& c) const {
    const auto count = std::count_if(c.pixels.begin(), c.pixels.end(), [&](const SeenPixel& p) {
      return claimed_[static_cast<std::size_t>(p.view)][static_cast<std::size_t>(p.index)] != 0;
    });
    return static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(1, c.pixels.size()));
  }

  /// Rasters of two models differ: claims the neighbourhood.
  void claim(const Candidate& c) {
    for (const auto& p : c.pixels) {
      const CameraIntrinsics& camera = scene_.views[static_cast<std::size_t>(p.view)].depth.camera;
      const int u = p.index % camera.width, v = p.index / camera.width;
      for (int y = std::max(0, v - 1); y <= std::min(camera.height - 1, v + 1); ++y)
        for (int x = std::max(0, u - 1); x <= std::min(camera.width - 1, u + 1); ++x)
          claimed_[static_cast<std::size_t>(p.view)][static_cast<std::size_t>(y * camera.width + x)] = 1;
    }
  }

 private:
  const DetectionScene& scene_;
  std::vector<std::vector<char>> claimed_;
};

}  // namespace

bool acceptable(const Detection& d, const DetectionOptions& options, double least) {
  if (options.method == "paper") return d.inlier_ratio >= options.accept_inlier_ratio;
  const double wanted = options.accept_score + kLittleVisible * std::max(0.0, kMuchVisible - d.visible);
  return d.score >= std::max(wanted, least) && d.visible >= kLeastVisible;
}

std::vector<std::size_t> without_conflicts(const std::vector<Candidate>& candidates,
                                           const std::vector<int>& missing, const DetectionScene& scene,
                                           const DetectionOptions& options, double least) {
  std::vector<std::size_t> order(candidates.size()), taken;
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return worth(candidates[a], options) > worth(candidates[b], options);
  });
  std::map<int, int> left;
  for (const int stone : missing) ++left[stone];
  Claims claims(scene);
  for (const std::size_t i : order) {
    const Candidate& c = candidates[i];
    if (!acceptable(c.detection, options, least) || left[c.detection.stone] == 0) continue;
    if (claims.overlap(c) > kLargestOverlap) continue;
    --left[c.detection.stone];
    claims.claim(c);
    taken.push_back(i);
  }
  return taken;
}

}  // namespace stonestack
