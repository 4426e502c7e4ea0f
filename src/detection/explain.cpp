#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "detection/hypotheses/candidates.hpp"
#include "detection/judge/verify.hpp"
#include "detection/prepare_scene.hpp"
#include "detection/trace.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::detection {
namespace {

constexpr double kSameMiddle = 0.5;  // times the model's radius: so near another's middle, it is at its place

/// Percent, as a whole number.
int percent(double share) {
  return static_cast<int>(std::lround(100.0 * share));
}

/// A reason for a lower score, and what may help.
struct Reason {
  double lost = 0.0;
  std::string text;
};

/// Reasons by weight, the strongest first, without those that hardly count.
std::vector<Reason> reasons_of(const ScoreLosses& lost) {
  std::array<Reason, 10> all = {{
      {lost.misfit,
       "the seen surface lies off the scan or is turned from it: is the scan of this stone, and in "
       "metres? Are the camera's intrinsics and depth unit right?"},
      {lost.seen_through,
       "surface behind it is seen where it should be: what is there is smaller, or it is not there"},
      {lost.in_front, "surface lies just in front of it: what is there is larger, or it is a neighbour"},
      {lost.hidden, "other things hide a part of it: take the picture from another side"},
      {lost.beside,
       "surface goes on just beside its own: what is there is another shape, or a thing touches it"},
      {lost.outline, "the seen surface goes on smoothly where it should end: what is there is larger"},
      {lost.below,
       "it would reach below the table or the plane it stands on: is the table's height as it was said?"},
      {lost.bend, "the seen surface is flatter than its own: what is there is another shape"},
      {lost.without_depth,
       "much of it has no depth where it should be seen: it is not there, or it is dark, shiny or out of "
       "range"},
      {lost.loose, "flat surface is seen without its outline: move the camera until its edges are seen"},
  }};
  std::stable_sort(all.begin(), all.end(), [](const Reason& a, const Reason& b) { return a.lost > b.lost; });
  std::vector<Reason> reasons;
  for (const Reason& reason : all)
    if (reason.lost > 0.01 && reasons.size() < 2) reasons.push_back(reason);
  return reasons;
}

/// The candidate of a stone that was accepted, or that came nearest to what it needed; null without one.
const TracedCandidate* nearest_candidate(const DetectionTrace& trace, StoneIndex stone) {
  const TracedCandidate* best = nullptr;
  const auto rank = [](const TracedCandidate& c) {
    return std::pair(c.accepted, c.detection.score - c.wanted);
  };
  for (const TracedTurn& turn : trace.turns)
    for (const TracedCandidate& c : turn.candidates)
      if (c.detection.stone == stone && (best == nullptr || rank(c) > rank(*best))) best = &c;
  return best;
}

std::size_t count_hypotheses(const DetectionTrace& trace, StoneIndex stone) {
  std::size_t count = 0;
  for (const TracedTurn& turn : trace.turns)
    count +=
        static_cast<std::size_t>(std::count_if(turn.hypotheses.begin(), turn.hypotheses.end(),
                                               [&](const TracedHypothesis& h) { return h.stone == stone; }));
  return count;
}

/// Describes what was looked at.
std::string seen_surface(const DetectionTrace& trace) {
  if (trace.turns.empty()) return "no surface was searched";
  const TracedTurn& first = trace.turns.front();
  int clusters = 0;
  for (const int c : first.cluster) clusters = std::max(clusters, c + 1);
  return concat(first.surface_C.size(), " points of surface in ", clusters, " clusters were searched");
}

/// The detection at whose place a pose lies; null where there is none.
const Detection* at_place(const DetectionResult& result, const DetectionModels::Data& data,
                          const Detection& d) {
  const DetectionModel& model = at(data.models, d.stone);
  const Eigen::Vector3d middle = d.T_C_O * model.centre;
  for (const Detection& other : result.detections) {
    const Eigen::Vector3d there = other.T_C_O * at(data.models, other.stone).centre;
    if ((there - middle).norm() < kSameMiddle * model.radius) return &other;
  }
  return nullptr;
}

void explain_refused(Explanation& out, const DetectionResult& result, const DetectionModels::Data& data,
                     const DetectionOptions& options) {
  const Detection& best = *out.best;
  const double score = options.method == "paper" ? best.inlier_ratio : best.score;
  const Detection* other = at_place(result, data, best);
  if (score >= out.wanted && result.detections.empty() && !result.note.empty()) {
    out.stage = "left out";
    out.text = concat("its best pose fits (", score, ", wanted ", out.wanted, "), but ", result.note);
    return;
  }
  if (score >= out.wanted && other != nullptr) {
    out.stage = "claimed by another";
    out.text = concat("its best pose fits (", score, ", wanted ", out.wanted, "), but ",
                      at(data.models, other->stone).name, " explains the same surface better (", other->score,
                      "); both are of like shape, or one of the two scans is wrong");
    return;
  }
  out.stage = "refuted";
  out.text = concat("its best pose scores ", score, " where ", out.wanted, " is wanted, with ",
                    percent(best.visible), " % of its surface seen");
  if (other != nullptr) out.text += concat(", at the place of ", at(data.models, other->stone).name);
  if (score >= out.wanted)
    out.text += "; that is too little to be sure, or others explain the most of it: take another picture";
  for (const Reason& reason : reasons_of(out.lost)) out.text += concat("; ", reason.lost, ": ", reason.text);
}

void explain_missing(Explanation& out, const DetectionResult& result, const DetectionModels::Data& data) {
  const DetectionTrace& trace = *result.trace;
  const DetectionModel& model = at(data.models, out.stone);
  const std::size_t hypotheses = count_hypotheses(trace, out.stone);
  if (trace.turns.empty() || trace.turns.front().surface_C.empty()) {
    out.stage = "no surface";
    out.text = result.note.empty() ? "nothing but the table is in range" : result.note;
  } else if (hypotheses == 0) {
    out.stage = "no hypothesis";
    out.text =
        concat(seen_surface(trace), ", and none is of a size that ", model.name, " (up to ",
               2.0 * model.radius, " m) could show: is it in range, in view and apart from what is larger?");
  } else {
    out.stage = "no pose";
    out.text =
        concat(seen_surface(trace), "; ", hypotheses, " poses of ", model.name,
               " were tried, and none fits even by half: is it in view, and is the scan of this stone?");
  }
}

}  // namespace

Explanation explain_stone(const DepthImage& image, const DetectionResult& result,
                          const DetectionModels& models, StoneIndex stone, const DetectionOptions& options,
                          const SceneKnowledge& known) {
  const auto& data = models.data();
  require(result.trace != nullptr, "an explanation needs a result with its trace: set detection's trace");
  require(stone.is_within(data.models.size()), "there are ", data.models.size(), " models, none with index ",
          stone);
  Explanation out;
  out.stone = stone;
  if (const TracedCandidate* nearest = nearest_candidate(*result.trace, stone))
    out.best = nearest->detection, out.wanted = nearest->wanted, out.lost = nearest->lost;
  const auto found = std::find_if(result.detections.begin(), result.detections.end(),
                                  [&](const Detection& d) { return d.stone == stone; });
  if (found != result.detections.end()) {
    out.best = *found;
    out.stage = "found";
    out.text = concat("score ", found->score, ", ", percent(found->visible), " % of its surface seen");
  } else if (!std::binary_search(result.trace->searched.begin(), result.trace->searched.end(), stone)) {
    out.stage = "not searched";
    out.text = "it was not asked for, or its pose was known";
  } else if (out.best) {
    explain_refused(out, result, data, options);
  } else {
    explain_missing(out, result, data);
  }
  if (!out.best) return out;
  const DetectionModel& model = at(data.models, stone);
  const DetectionScene scene =
      prepare_scene(preprocess(image, known.table_C, true, options), data, options, known);
  if (!scene.views.empty())
    out.evidence = pixel_evidence(model, out.best->T_C_O, scene, tolerance(model, out.best->T_C_O, scene));
  return out;
}

}  // namespace stonestack::detection
