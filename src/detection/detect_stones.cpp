#include "stonestack/detection/detect_stones.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "detection/candidates.hpp"
#include "detection/describe.hpp"
#include "detection/matching.hpp"
#include "detection/models.hpp"
#include "detection/preprocess.hpp"
#include "detection/sweep.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack {
namespace {

constexpr double kLeastVisible = 0.04;   // of the whole surface: less is no evidence
constexpr double kLargestOverlap = 0.3;  // of a candidate's pixels that an accepted one explains already

std::vector<std::vector<int>> members(const DetectionScene& scene) {
  std::vector<std::vector<int>> clusters(static_cast<std::size_t>(scene.clusters));
  for (std::size_t i = 0; i < scene.cluster.size(); ++i)
    if (scene.cluster[i] >= 0)
      clusters[static_cast<std::size_t>(scene.cluster[i])].push_back(static_cast<int>(i));
  return clusters;
}

std::vector<Hypothesis> feature_hypotheses(const DetectionModel& model, const Features& seen,
                                           const DetectionOptions& options) {
  const auto matches = match_features(seen, model.features, options.neighbours);
  ConsistencyOptions grouping;
  grouping.size = options.consistency_size;
  grouping.fewest = options.consistency_fewest;
  grouping.best = options.best;
  return consistent_groups(matches, seen, model.features, grouping);
}

void add_swept(std::vector<Hypothesis>& hypotheses, const DetectionModel& model, const DetectionScene& scene,
               const std::vector<std::vector<int>>& clusters) {
  for (const auto& cluster : clusters) {
    const auto more = sweep_orientations(model, scene.surface, cluster, {});
    hypotheses.insert(hypotheses.end(), more.begin(), more.end());
  }
}

/// What a look at a scene tries.
struct Look {
  const Features* seen = nullptr;  ///< hypotheses from descriptors, if given
  bool sweep = false;              ///< and from all orientations on each cluster
};

/// Candidates of every missing model.
std::vector<Candidate> search(const DetectionModels::Data& data, std::span<const int> missing,
                              const DetectionScene& scene, const Look& look,
                              const DetectionOptions& options) {
  const auto clusters = members(scene);
  std::vector<std::vector<Candidate>> found(missing.size());
  tbb::parallel_for(std::size_t{0}, missing.size(), [&](std::size_t k) {
    const DetectionModel& model = data.models[static_cast<std::size_t>(missing[k])];
    std::vector<Hypothesis> hypotheses;
    if (look.seen != nullptr) hypotheses = feature_hypotheses(model, *look.seen, options);
    if (look.sweep) add_swept(hypotheses, model, scene, clusters);
    found[k] = judge_hypotheses(model, missing[k], hypotheses, scene, options);
  });
  std::vector<Candidate> all;
  for (auto& some : found)
    all.insert(all.end(), std::make_move_iterator(some.begin()), std::make_move_iterator(some.end()));
  return all;
}

/// Score first, but a large surface that fits is worth more than a small one. The paper has the inlier ratio.
double worth(const Candidate& c, const DetectionOptions& options) {
  if (options.method == "paper") return c.detection.inlier_ratio;
  return c.detection.score * std::cbrt(static_cast<double>(c.pixels.size()));
}

bool acceptable(const Detection& d, const DetectionOptions& options) {
  if (options.method == "paper") return d.inlier_ratio >= options.accept_inlier_ratio;
  return d.score >= options.accept_score && d.visible >= kLeastVisible;
}

/// Takes candidates in order of worth, at most one a model, each only if what it explains is mostly still
/// free.
std::vector<Candidate> without_conflicts(std::vector<Candidate> candidates, const CameraIntrinsics& camera,
                                         const DetectionOptions& options) {
  std::stable_sort(candidates.begin(), candidates.end(), [&](const Candidate& a, const Candidate& b) {
    return worth(a, options) > worth(b, options);
  });
  std::vector<char> claimed(static_cast<std::size_t>(camera.width * camera.height), 0);
  std::vector<Candidate> taken;
  for (auto& c : candidates) {
    const Detection& d = c.detection;
    if (!acceptable(d, options)) continue;
    const auto overlap = std::count_if(c.pixels.begin(), c.pixels.end(),
                                       [&](int i) { return claimed[static_cast<std::size_t>(i)] != 0; });
    if (static_cast<double>(overlap) > kLargestOverlap * static_cast<double>(c.pixels.size())) continue;
    if (std::any_of(taken.begin(), taken.end(),
                    [&](const Candidate& t) { return t.detection.stone == d.stone; }))
      continue;
    for (const int i : c.pixels) {  // rasters of two models differ: claim the neighbourhood
      const int u = i % camera.width, v = i / camera.width;
      for (int y = std::max(0, v - 1); y <= std::min(camera.height - 1, v + 1); ++y)
        for (int x = std::max(0, u - 1); x <= std::min(camera.width - 1, u + 1); ++x)
          claimed[static_cast<std::size_t>(y * camera.width + x)] = 1;
    }
    taken.push_back(std::move(c));
  }
  return taken;
}

std::vector<int> wanted_models(std::span<const int> wanted, const SceneKnowledge& known, int count) {
  std::vector<int> all(wanted.begin(), wanted.end());
  if (all.empty()) {
    all.resize(static_cast<std::size_t>(count));
    std::iota(all.begin(), all.end(), 0);
  }
  for (const int i : all) require(i >= 0 && i < count, "there are ", count, " models, none with index ", i);
  for (const auto& k : known.stones)
    require(k.stone >= 0 && k.stone < count, "there are ", count, " models, none with index ", k.stone);
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  std::erase_if(all, [&](int i) {
    return std::any_of(known.stones.begin(), known.stones.end(),
                       [&](const KnownStone& k) { return k.stone == i; });
  });
  return all;
}

/// Looks again and again at what is still unexplained, for what is still missing: the cheap sweep first,
/// which finds stones that stand alone, then descriptors on the rest, then the sweep on what these have set
/// apart.
std::vector<Candidate> search_in_turns(const DetectionModels::Data& data, std::vector<int> missing,
                                       DetectionScene scene, const DetectionOptions& options) {
  std::vector<Candidate> taken;
  bool changed = true, described = false;
  while (!missing.empty() && scene.clusters > 0) {
    throw_if_interrupted();
    const bool sweep = options.sweep && changed;
    if (!sweep && described && !changed) break;
    const bool describe = !sweep;
    Features seen;
    if (describe) seen = describe_scene(scene, data.options);
    auto found = without_conflicts(search(data, missing, scene, {describe ? &seen : nullptr, sweep}, options),
                                   scene.depth.camera, options);
    described = describe;
    changed = !found.empty();
    std::vector<KnownStone> stones;
    for (auto& f : found) {
      stones.push_back({f.detection.stone, f.detection.T_C_O});
      std::erase(missing, f.detection.stone);
      taken.push_back(std::move(f));
    }
    if (changed) scene = without_stones(std::move(scene), data, stones, options);
    if (!options.sweep) break;
  }
  return taken;
}

}  // namespace

DetectionResult detect_stones(const DepthImage& image, const DetectionModels& models,
                              std::span<const int> wanted, const DetectionOptions& options,
                              const SceneKnowledge& known) {
  const auto& data = models.data();
  const std::vector<int> missing = wanted_models(wanted, known, static_cast<int>(data.models.size()));
  DetectionScene scene = see_scene(image, data, known, true, options);
  DetectionResult result;
  result.table_C = scene.table_C;
  result.note = scene.note;
  if (scene.clusters == 0 || missing.empty()) return result;
  const auto taken = search_in_turns(data, missing, std::move(scene), options);
  for (const auto& t : taken) result.detections.push_back(t.detection);
  std::stable_sort(result.detections.begin(), result.detections.end(),
                   [](const Detection& a, const Detection& b) { return a.score > b.score; });
  if (result.detections.empty()) result.note = "no wanted stone fits what stands on the table";
  return result;
}

}  // namespace stonestack
