#include "stonestack/detection/detect_stones.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "detection/features/describe.hpp"
#include "detection/hypotheses/depth_scale.hpp"
#include "detection/hypotheses/joint_refine.hpp"
#include "detection/hypotheses/search_in_turns.hpp"
#include "detection/judge/accept.hpp"
#include "detection/judge/alternatives.hpp"
#include "detection/judge/identity.hpp"
#include "detection/prepare_scene.hpp"
#include "detection/trace.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::detection {
namespace {

constexpr double kDoubtfulScale = 0.02;  // of depth: SR300 scenes come out within 0.01 (bench)
constexpr double kWrongScale = 0.05;     // a stone 0.7 m away is 35 mm off
constexpr double kSurely = 3.0;          // standard deviations

/// The models to search for, ascending, each as often as it may still be found.
std::vector<StoneIndex> wanted_models(std::span<const StoneIndex> wanted, const SceneKnowledge& known,
                                      std::size_t count, const DetectionOptions& options) {
  std::vector<StoneIndex> models(wanted.begin(), wanted.end());
  if (models.empty()) models = first_stones(count);
  for (const StoneIndex i : models)
    require(i.is_within(count), "there are ", count, " models, none with index ", i);
  for (const auto& k : known.stones)
    require(k.stone.is_within(count), "there are ", count, " models, none with index ", k.stone);
  std::sort(models.begin(), models.end());
  std::vector<StoneIndex> missing;
  for (auto at = models.begin(); at != models.end();) {
    const auto next = std::upper_bound(at, models.end(), *at);
    const auto copies = std::max<std::ptrdiff_t>(options.copies, next - at);
    const auto placed = std::count_if(known.stones.begin(), known.stones.end(),
                                      [&](const KnownStone& k) { return k.stone == *at; });
    missing.insert(missing.end(), static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, copies - placed)),
                   *at);
    at = next;
  }
  return missing;
}

/// Reports when all stones seem too large or too small, and drops them when they do by so much that every
/// position is wrong by centimetres.
void check_depth_scale(DetectionResult& result, const DetectionModels::Data& data,
                       const DetectionScene& scene) {
  const DepthScale scale = fit_depth_scale(result.detections, data, scene);
  result.depth_scale = scale.factor, result.depth_scale_sigma = scale.sigma;
  const double off = std::abs(std::log(scale.factor));
  if (off < kDoubtfulScale || off < kSurely * scale.sigma) return;
  result.note = concat("seen depths are ", scale.factor, " times (+- ", scale.sigma,
                       ") what the sizes of the stones say: check the depth unit and the camera's intrinsics "
                       "(focal lengths, size of the image)");
  if (off < kWrongScale) return;
  result.note += concat("; the ", result.detections.size(), " stones found lie elsewhere and are left out");
  result.detections.clear();
}

/// Finds what is missing in a scene that is ready.
DetectionResult find_in(DetectionScene scene, const DetectionModels::Data& data,
                        std::vector<StoneIndex> missing, const DetectionOptions& options,
                        const SceneKnowledge& known) {
  scene = prepare_scene(std::move(scene), data, options, known);
  DetectionResult result;
  result.table_C = scene.table_C;
  result.note = scene.note;
  const auto trace = options.trace ? std::make_shared<DetectionTrace>() : nullptr;
  if (trace) trace->searched = missing;
  if (scene.clusters == 0 || missing.empty()) {
    if (trace) trace->turns.emplace_back().surface_C = scene.surface.points;
    result.trace = trace;
    return result;
  }
  const auto taken = search_in_turns(data, std::move(missing), scene, options, trace.get());
  result.trace = trace;
  for (const auto& t : taken) result.detections.push_back(t.detection);
  if (options.method != "paper")
    result.detections =
        without_doubles(among_alternatives(std::move(result.detections), data, scene, options, known.stones),
                        data, scene, options);
  result.detections = refined_together(std::move(result.detections), data, scene);
  for (auto& d : result.detections) widen_by_alternatives(d);
  std::stable_sort(result.detections.begin(), result.detections.end(),
                   [](const Detection& a, const Detection& b) { return a.score > b.score; });
  if (result.detections.empty()) {
    result.note = result.table_C ? concat("no wanted stone fits what stands on the table, the plane ",
                                          std::abs(result.table_C->offset), " m away")
                                 : "no wanted stone fits what is in view, where no table is seen";
    return result;
  }
  // Wrong poses, which the paper's inlier ratio takes, have sizes of their own.
  if (options.method != "paper") check_depth_scale(result, data, scene);
  return result;
}

}  // namespace

DetectionResult detect_stones(const DepthImage& image, const DetectionModels& models,
                              std::span<const StoneIndex> wanted, const DetectionOptions& options,
                              const SceneKnowledge& known) {
  require_usable(options);
  const auto& data = models.data();
  auto missing = wanted_models(wanted, known, data.models.size(), options);
  return find_in(preprocess(image, known.table_C, true, options), data, std::move(missing), options, known);
}

DetectionResult detect_stones(std::span<const DepthView> views, const DetectionModels& models,
                              std::span<const StoneIndex> wanted, const DetectionOptions& options,
                              const SceneKnowledge& known) {
  require_usable(options);
  const auto& data = models.data();
  auto missing = wanted_models(wanted, known, data.models.size(), options);
  return find_in(preprocess(views, known.table_C, true, options), data, std::move(missing), options, known);
}

}  // namespace stonestack::detection
