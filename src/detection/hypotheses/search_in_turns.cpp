#include "detection/hypotheses/search_in_turns.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>

#include "detection/constants.hpp"
#include "detection/features/describe.hpp"
#include "detection/features/matching.hpp"
#include "detection/hypotheses/search_memory.hpp"
#include "detection/hypotheses/sweep.hpp"
#include "detection/judge/accept.hpp"
#include "detection/scene/split_parts.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::detection {
namespace {

constexpr double kWiderGap = 3.0;         // times the gap of clusters
constexpr double kNearlyAccepted = 0.10;  // below the accept score
constexpr double kWellVisible = 0.13;     // of the whole surface

/// Points of one cluster that one view saw.
struct SeenCluster {
  int view = 0;
  std::vector<int> points;
  std::uint64_t name = 0;  ///< clusters of the same points have the same, in whatever turn
};

void name(std::vector<SeenCluster>& clusters, const SurfacePoints& seen) {
  for (auto& c : clusters) c.name = fingerprint(seen, c.points, c.view);
}

/// @param labels the cluster of each point of the scene's surface, or -1
std::vector<SeenCluster> seen_clusters(const DetectionScene& scene, const std::vector<int>& labels) {
  const std::size_t views = scene.views.size();
  int count = 0;
  for (const int label : labels) count = std::max(count, label + 1);
  std::vector<SeenCluster> all(static_cast<std::size_t>(count) * views);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] < 0) continue;
    auto& cluster =
        all[static_cast<std::size_t>(labels[i]) * views + static_cast<std::size_t>(scene.view_of[i])];
    cluster.view = scene.view_of[i];
    cluster.points.push_back(static_cast<int>(i));
  }
  std::erase_if(all,
                [&](const SeenCluster& c) { return static_cast<int>(c.points.size()) < kClusterPoints; });
  return all;
}

/// Clusters, those that wider gaps join (a stone that holes or shadow have torn), and the parts that creases
/// split them into.
std::vector<SeenCluster> with_parts(const DetectionScene& scene) {
  const auto clusters = seen_clusters(scene, scene.cluster);
  std::vector<SeenCluster> all = clusters;
  const auto joined =
      cluster_points(scene.surface.points, static_cast<float>(kWiderGap * kClusterGap), kClusterPoints);
  for (auto& cluster : seen_clusters(scene, joined)) {
    const bool known = std::any_of(clusters.begin(), clusters.end(), [&](const SeenCluster& c) {
      return c.view == cluster.view && c.points.size() == cluster.points.size() &&
             c.points[0] == cluster.points[0];
    });
    if (!known) all.push_back(std::move(cluster));
  }
  for (const auto& cluster : clusters)
    for (auto& part : split_parts(scene.surface, cluster.points))
      all.push_back({cluster.view, std::move(part)});
  return all;
}

/// Method that one turn tries.
enum class Turn {
  kSweep,     ///< some orientations on each cluster
  kParts,     ///< and on parts of clusters
  kDescribe,  ///< descriptors
  kThorough,  ///< more orientations, also on parts of clusters
};

/// Settings of one pass over a scene.
struct SearchView {
  bool describes = false;             ///< hypotheses from descriptors: ...
  const Features* seen = nullptr;     ///< ... of these, where the memory has none
  std::vector<SeenCluster> clusters;  ///< and from all orientations on each of these
  bool thorough = false;              ///< sweep
};

/// Sweep of the last turn: as many orientations as the budget of a scene allows.
SweepOptions thorough_sweep() {
  SweepOptions options;
  options.best = 60;
  options.apart = 0.2;
  options.shifts = 3;
  options.aside = 0.022;
  options.glance = 0.2;
  options.area_low = 0.15;
  options.area_high = 1.6;
  return options;
}

/// State of the search for one model.
struct ModelSearch {
  std::vector<Correspondence> matches;
  std::vector<Hypothesis> grouped, swept;
  std::vector<Candidate> candidates;
};

ModelSearch search_model(const DetectionModels::Data& data, StoneIndex stone, const DetectionScene& scene,
                         const SearchView& view, const DetectionOptions& options, ModelMemory& memory) {
  const DetectionModel& model = at(data.models, stone);
  ModelSearch out;
  if (view.describes && memory.grouped) {
    out.grouped = *memory.grouped;
  } else if (view.describes) {
    const Features& features = features_of(model, data.options);
    out.matches = options.matching == "kdtree" ? match_features_kdtree(*view.seen, features, kNeighbours)
                                               : match_features(*view.seen, features, kNeighbours);
    ConsistencyOptions grouping;
    grouping.size = kConsistencySize;
    grouping.fewest = kMinConsistent;
    grouping.best = kBestHypotheses;
    out.grouped = consistent_groups(out.matches, *view.seen, features, grouping);
    memory.grouped = out.grouped;
  }
  const SweepOptions sweep = view.thorough ? thorough_sweep() : SweepOptions{};
  auto& swept = view.thorough ? memory.swept_thoroughly : memory.swept;
  for (const auto& cluster : view.clusters) {
    const auto [known, is_new] = swept.try_emplace(cluster.name);
    const Eigen::Vector3f eye =
        scene.views[static_cast<std::size_t>(cluster.view)].T_C_V.translation().cast<float>();
    if (is_new) known->second = sweep_orientations(model, scene.surface, cluster.points, eye, sweep);
    out.swept.insert(out.swept.end(), known->second.begin(), known->second.end());
  }
  std::vector<Hypothesis> all = out.grouped;
  all.insert(all.end(), out.swept.begin(), out.swept.end());
  out.candidates = judge_hypotheses(model, stone, all, scene, options, kKeptPoses, &memory);
  return out;
}

void note_search(TracedTurn& turn, const ModelSearch& found, StoneIndex stone, const SearchView& view,
                 const DetectionModels::Data& data) {
  for (const auto& m : found.matches) {
    const Features& of_model = features_of(at(data.models, stone), data.options);
    turn.matches.push_back({stone, view.seen->points[static_cast<std::size_t>(m.scene)],
                            of_model.points[static_cast<std::size_t>(m.model)], m.distance});
  }
  for (const auto& h : found.grouped) turn.hypotheses.push_back({stone, "consistency", h.support, h.T_C_O});
  for (const auto& h : found.swept) turn.hypotheses.push_back({stone, "sweep", h.support, h.T_C_O});
}

/// Candidates of every missing model.
std::vector<Candidate> search(const DetectionModels::Data& data, const std::vector<StoneIndex>& missing,
                              const DetectionScene& scene, const SearchView& view,
                              const DetectionOptions& options, std::vector<ModelMemory>& memory,
                              TracedTurn* turn) {
  std::vector<StoneIndex> stones = missing;
  stones.erase(std::unique(stones.begin(), stones.end()), stones.end());
  std::vector<ModelSearch> found(stones.size());
  tbb::parallel_for(std::size_t{0}, stones.size(), [&](std::size_t k) {
    found[k] = search_model(data, stones[k], scene, view, options, at(memory, stones[k]));
  });
  std::vector<Candidate> all;
  for (std::size_t k = 0; k < stones.size(); ++k) {
    if (turn != nullptr) note_search(*turn, found[k], stones[k], view, data);
    all.insert(all.end(), std::make_move_iterator(found[k].candidates.begin()),
               std::make_move_iterator(found[k].candidates.end()));
  }
  return all;
}

void note_scene(TracedTurn& turn, const DetectionScene& scene, const Features& seen) {
  turn.surface_C = scene.surface.points;
  turn.cluster = scene.cluster;
  turn.keypoints_C = seen.points;
}

void note_candidates(TracedTurn& turn, const std::vector<Candidate>& all,
                     const std::vector<std::size_t>& taken, const DetectionScene& scene,
                     const DetectionOptions& options) {
  for (const auto& c : all)
    turn.candidates.push_back(
        {c.detection, false, wanted_score(c.detection, scene, options, Demand::kLikely), c.lost});
  for (const std::size_t i : taken) turn.candidates[i].accepted = true;
}

/// How far a search has come.
struct Search {
  std::vector<StoneIndex> missing;
  DetectionScene scene;  ///< what is still unexplained
  std::vector<Candidate> taken;
  std::vector<Candidate> refused;  ///< since something was taken last
  std::vector<SeenCluster> parts;  ///< of `scene`, once they were looked for
};

SearchView search_view(Turn turn, Search& so_far, const Features& seen) {
  if (turn == Turn::kDescribe) return {true, &seen, {}, false};
  SearchView view{false, nullptr, {}, turn == Turn::kThorough};
  if (turn == Turn::kSweep) {
    view.clusters = seen_clusters(so_far.scene, so_far.scene.cluster);
    name(view.clusters, so_far.scene.surface);
    return view;
  }
  if (so_far.parts.empty()) {
    so_far.parts = with_parts(so_far.scene);
    name(so_far.parts, so_far.scene.surface);
  }
  view.clusters = so_far.parts;
  return view;
}

/// Chooses the next turn: what a turn has found sets something apart, so the cheap sweep is worth another
/// try.
std::optional<Turn> turn_after(Turn turn, bool found, const DetectionOptions& options) {
  if (!options.sweep) return {};  // the paper searches once
  if (found) return Turn::kSweep;
  if (turn == Turn::kSweep) return Turn::kParts;
  if (turn == Turn::kParts) return Turn::kDescribe;
  if (turn == Turn::kDescribe) return Turn::kThorough;
  return {};
}

void take(Search& search, Candidate candidate) {
  search.missing.erase(std::find(search.missing.begin(), search.missing.end(), candidate.detection.stone));
  search.taken.push_back(std::move(candidate));
}

std::vector<KnownStone> poses_of(std::span<const Candidate> candidates) {
  std::vector<KnownStone> stones;
  for (const auto& c : candidates) stones.push_back({c.detection.stone, c.detection.T_C_O});
  return stones;
}

/// Turn after turn until nothing more is found.
void take_turns(const DetectionModels::Data& data, Search& so_far, const DetectionOptions& options,
                std::vector<ModelMemory>& memory, DetectionTrace* trace) {
  Turn turn = options.sweep ? Turn::kSweep : Turn::kDescribe;
  while (!so_far.missing.empty() && so_far.scene.clusters > 0) {
    throw_if_interrupted();
    Features seen;
    const bool described = std::all_of(so_far.missing.begin(), so_far.missing.end(), [&](StoneIndex stone) {
      return at(memory, stone).grouped.has_value();
    });
    if (turn == Turn::kDescribe && !described) seen = describe_scene(so_far.scene, data.options);
    const SearchView view = search_view(turn, so_far, seen);
    TracedTurn* noted = trace != nullptr ? &trace->turns.emplace_back() : nullptr;
    if (noted != nullptr) note_scene(*noted, so_far.scene, seen);
    auto found = search(data, so_far.missing, so_far.scene, view, options, memory, noted);
    auto accepted = without_conflicts(found, so_far.missing, so_far.scene, options, Demand::kCertain);
    if (accepted.empty() && !turn_after(turn, false, options)) {
      found.insert(found.end(), so_far.refused.begin(), so_far.refused.end());
      accepted = without_conflicts(found, so_far.missing, so_far.scene, options, Demand::kLikely);
    }
    if (noted != nullptr) note_candidates(*noted, found, accepted, so_far.scene, options);
    const std::size_t before = so_far.taken.size();
    for (const std::size_t i : accepted) take(so_far, found[i]);
    so_far.scene =
        without_stones(std::move(so_far.scene), data, poses_of(std::span(so_far.taken).subspan(before)));
    if (!accepted.empty()) so_far.parts.clear();
    so_far.refused.clear();  // where something was found, they are judged anew
    if (accepted.empty()) so_far.refused = std::move(found);
    const auto next = turn_after(turn, !accepted.empty(), options);
    if (!next) break;
    turn = *next;
  }
}

/// A stone may be refused because of one before it that was not found either, as the first one stands in its
/// way: takes the likeliest refused pose for granted, searches for the rest then, and keeps all of it if
/// that pose stands the check once the others are explained.
void take_for_granted(const DetectionModels::Data& data, Search& so_far, const DetectionOptions& options,
                      std::vector<ModelMemory>& memory) {
  auto refused = so_far.refused;
  std::erase_if(refused, [&](const Candidate& c) {
    return c.detection.score < options.accept_score - kNearlyAccepted || c.detection.visible < kWellVisible ||
           std::count(so_far.missing.begin(), so_far.missing.end(), c.detection.stone) == 0;
  });
  const auto best = std::max_element(
      refused.begin(), refused.end(),
      [](const Candidate& a, const Candidate& b) { return a.detection.score < b.detection.score; });
  if (best == refused.end()) return;
  const auto granted = poses_of(std::span(&*best, 1));
  Search rest{so_far.missing, without_stones(so_far.scene, data, granted), {}, {}, {}};
  take(rest, *best);
  rest.taken.clear();
  take_turns(data, rest, options, memory, nullptr);
  if (rest.taken.empty()) return;
  const DetectionScene alone = without_stones(so_far.scene, data, poses_of(rest.taken));
  const Hypothesis again{best->detection.T_C_O, 1.0};
  auto judged = judge_hypotheses(at(data.models, best->detection.stone), best->detection.stone,
                                 std::span(&again, 1), alone, options);
  if (judged.empty() || !acceptable(judged.front().detection, alone, options, Demand::kLikely)) return;
  take(so_far, std::move(judged.front()));
  for (auto& c : rest.taken) take(so_far, std::move(c));
}

}  // namespace

std::vector<Candidate> search_in_turns(const DetectionModels::Data& data, std::vector<StoneIndex> missing,
                                       DetectionScene scene, const DetectionOptions& options,
                                       DetectionTrace* trace) {
  Search so_far{std::move(missing), std::move(scene), {}, {}, {}};
  std::vector<ModelMemory> memory(data.models.size());
  take_turns(data, so_far, options, memory, trace);
  if (options.sweep && !so_far.missing.empty()) take_for_granted(data, so_far, options, memory);
  return std::move(so_far.taken);
}

}  // namespace stonestack::detection
