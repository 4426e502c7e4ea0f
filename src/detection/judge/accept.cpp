#include "detection/judge/accept.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace stonestack::detection {
namespace {

constexpr double kMinVisible = 0.04;    // of the whole surface: less is no evidence
constexpr double kMuchVisible = 0.13;   // of the whole surface: less must fit the better ...
constexpr double kLittleVisible = 1.5;  // ... by this much score for all that is missing (bench: hidden)
// Another stone of like shape scores up to 0.94 (limestones), and what it explains would be lost to
// the right one: a score below this waits until everything has been tried.
constexpr double kCertain = 0.95;
// A mirror image of a stone scored up to 0.875 in a clean image, where right poses of a single view score
// 0.91 and up (bench: mirrored, hidden). Views joined fit less well.
constexpr double kCleaner = 0.04;         // above the accept score: a right pose in a clean image of one view
constexpr double kUsualNoise = 0.0006;    // m: noisier images fit right poses the worse, ...
constexpr double kNoiseCosts = 50.0;      // ... by this much score a metre (bench: d435) ...
constexpr double kNoisiest = 0.001;       // ... of at most so much more noise [m]
constexpr double kCleanNoise = 0.0015;    // m: noisier depths fit shapes that are not there, ...
constexpr double kMuchMore = 2.0;         // ... unless more is seen, up to so many times as much
constexpr double kUsuallyLacking = 0.03;  // of the score of a right pose
constexpr double kMaxOverlap = 0.3;       // of a candidate's pixels that an accepted one explains already
constexpr double kDouble = 0.5;           // the same of final poses: the same stone twice

/// Image pixels that a candidate explains: models are drawn at steps of their own.
double image_area(const Candidate& c) {
  double sum = 0;
  for (const auto& p : c.pixels) sum += static_cast<double>(p.step) * p.step;
  return sum;
}

/// Score that a right pose may lack by the noise where it lies.
double noise_costs(double noise) {
  return kNoiseCosts * std::clamp(noise - kUsualNoise, 0.0, kNoisiest);
}

/// Score first, by what it lacks: 0.99 against 0.96 is stronger evidence than 0.93 against 0.90. But a large
/// surface that fits is worth more than a small one. The paper has the inlier ratio.
double worth(const Candidate& c, const DetectionOptions& options) {
  if (options.method == "paper") return c.detection.inlier_ratio;
  const double lacking = 1.0 - c.detection.score + kUsuallyLacking;
  return c.detection.score / lacking * std::sqrt(image_area(c));
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

  /// Rasters of two models differ: claims all that each drawn pixel stands for.
  void claim(const Candidate& c) {
    for (const auto& p : c.pixels) {
      const CameraIntrinsics& camera = scene_.views[static_cast<std::size_t>(p.view)].depth.camera;
      const int u = p.index % camera.width, v = p.index / camera.width;
      const int reach = std::max(1, (p.step + 1) / 2);
      for (int y = std::max(0, v - reach); y <= std::min(camera.height - 1, v + reach); ++y)
        for (int x = std::max(0, u - reach); x <= std::min(camera.width - 1, u + reach); ++x)
          claimed_[static_cast<std::size_t>(p.view)][static_cast<std::size_t>(y * camera.width + x)] = 1;
    }
  }

 private:
  const DetectionScene& scene_;
  std::vector<std::vector<char>> claimed_;
};

}  // namespace

double wanted_score(const Detection& d, const DetectionScene& scene, const DetectionOptions& options,
                    Demand demand) {
  if (options.method == "paper") return options.accept_inlier_ratio;
  const double noise = noise_at(scene, d.T_C_O.translation().z()), costs = noise_costs(noise);
  const double base =
      demand == Demand::kCertain ? std::max(options.accept_score, kCertain - costs) : options.accept_score;
  const double much = kMuchVisible * std::clamp(noise / kCleanNoise, 1.0, kMuchMore);
  const double wanted = base + kLittleVisible * std::max(0.0, much - d.visible);
  if (scene.views.size() > 1) return wanted;
  return std::max(wanted, options.accept_score + std::max(0.0, kCleaner - costs));
}

bool acceptable(const Detection& d, const DetectionScene& scene, const DetectionOptions& options,
                Demand demand) {
  const double wanted = wanted_score(d, scene, options, demand);
  if (options.method == "paper") return d.inlier_ratio >= wanted;
  return d.score >= wanted && d.visible >= kMinVisible;
}

std::vector<Detection> without_doubles(const std::vector<Detection>& found, const DetectionModels::Data& data,
                                       const DetectionScene& scene, const DetectionOptions& options) {
  std::vector<Candidate> candidates;
  for (const auto& d : found)
    candidates.push_back({d, explained_pixels(at(data.models, d.stone), d.T_C_O, scene)});
  std::stable_sort(candidates.begin(), candidates.end(), [&](const Candidate& a, const Candidate& b) {
    return worth(a, options) > worth(b, options);
  });
  Claims claims(scene);
  std::vector<Detection> kept;
  for (const auto& c : candidates) {
    if (c.detection.visible < kMinVisible || claims.overlap(c) > kDouble) continue;
    claims.claim(c);
    kept.push_back(c.detection);
  }
  return kept;
}

std::vector<std::size_t> without_conflicts(const std::vector<Candidate>& candidates,
                                           const std::vector<StoneIndex>& missing,
                                           const DetectionScene& scene, const DetectionOptions& options,
                                           Demand demand) {
  std::vector<std::size_t> order(candidates.size()), taken;
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return worth(candidates[a], options) > worth(candidates[b], options);
  });
  std::map<StoneIndex, int> left;
  for (const StoneIndex stone : missing) ++left[stone];
  Claims claims(scene);
  for (const std::size_t i : order) {
    const Candidate& c = candidates[i];
    if (!acceptable(c.detection, scene, options, demand) || left[c.detection.stone] == 0) continue;
    if (claims.overlap(c) > kMaxOverlap) continue;
    --left[c.detection.stone];
    claims.claim(c);
    taken.push_back(i);
  }
  return taken;
}

}  // namespace stonestack::detection
