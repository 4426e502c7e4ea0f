#include "detection/judge/identity.hpp"

#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "detection/hypotheses/candidates.hpp"
#include "detection/hypotheses/sweep.hpp"
#include "detection/judge/alternatives.hpp"

namespace stonestack::detection {
namespace {

constexpr double kSimilarExtents =
    0.12;  // of their logarithm: limestones differ by 0.09 at least, twins by 0.05
constexpr double kScoreScale = 0.004;  // a pose that scores this much less is e times less likely (bench)
constexpr double kAreaScale = 0.05;    // of score, for a surface e times as large that is explained
constexpr double kNegligible = 0.02;   // weight
constexpr double kNoRival = 0.05;      // a stone that scores this much less at first sight
constexpr double kItsOwn = 0.008;      // m, from the detected stone's surface

/// Standard deviations of the surface along its principal axes, ascending.
Eigen::Vector3d extents(const DetectionModel& model) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double area = 0;
  for (std::size_t i = 0; i < model.surface.points.size(); ++i) {
    mean += model.surface.areas[i] * model.surface.points[i].cast<double>();
    area += model.surface.areas[i];
  }
  mean /= area;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < model.surface.points.size(); ++i) {
    const Eigen::Vector3d off = model.surface.points[i].cast<double>() - mean;
    spread += model.surface.areas[i] / area * off * off.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  return axes.eigenvalues().cwiseMax(1e-12).cwiseSqrt();
}

/// The points that show a detection, of the view that sees most of it, and that view.
std::pair<std::vector<int>, int> shown_points(const Detection& d, const DetectionModel& model,
                                              const DetectionScene& scene) {
  std::vector<std::vector<int>> shown(scene.views.size());
  for (std::size_t i = 0; i < scene.surface.points.size(); ++i)
    if (explains(model, d.T_C_O, scene.surface.points[i], kItsOwn))
      shown[static_cast<std::size_t>(scene.view_of[i])].push_back(static_cast<int>(i));
  const auto max = std::max_element(shown.begin(), shown.end(),
                                    [](const auto& a, const auto& b) { return a.size() < b.size(); });
  return {*max, static_cast<int>(max - shown.begin())};
}

/// The best pose of each other stone of like shape that fits nearly as well at first sight.
std::vector<Detection> rivals_at(const Detection& d, const DetectionModels::Data& data,
                                 const DetectionScene& scene, const DetectionOptions& options,
                                 std::span<const KnownStone> known) {
  std::vector<StoneIndex> stones = at(data.rivals, d.stone);
  std::erase_if(stones, [&](StoneIndex s) {
    return std::any_of(known.begin(), known.end(), [&](const KnownStone& k) { return k.stone == s; });
  });
  if (stones.empty()) return {};
  const auto shown = shown_points(d, at(data.models, d.stone), scene);
  const auto& points = shown.first;
  const Eigen::Vector3f eye =
      scene.views[static_cast<std::size_t>(shown.second)].T_C_V.translation().cast<float>();
  std::vector<std::vector<Candidate>> judged(stones.size());
  tbb::parallel_for(std::size_t{0}, stones.size(), [&](std::size_t k) {
    const DetectionModel& model = at(data.models, stones[k]);
    const auto hypotheses = sweep_orientations(model, scene.surface, points, eye, {});
    judged[k] = judge_hypotheses(model, stones[k], hypotheses, scene, options, 1);
  });
  std::vector<Detection> rivals;
  for (const auto& one : judged)
    if (!one.empty() && one.front().detection.score > d.score - kNoRival)
      rivals.push_back(one.front().detection);
  return rivals;
}

/// A pose and what speaks for it.
struct Evidence {
  Detection pose;
  double weight = 0.0;
};

/// Weighs `all`; those of other stones by how much of the scene they explain as well.
std::vector<Evidence> weighed(const std::vector<Detection>& all, const DetectionModels::Data& data) {
  const auto area = [&](const Detection& d) {
    return std::max(1e-6, d.visible * at(data.models, d.stone).area);
  };
  const Detection& own = all.front();
  std::vector<Evidence> evidence;
  double sum = 0;
  for (const auto& one : all) {
    double more = one.score - own.score;
    if (one.stone != own.stone) more += kAreaScale * std::log(area(one) / area(own));
    evidence.push_back({one, std::exp(more / kScoreScale)});
    sum += evidence.back().weight;
  }
  for (auto& e : evidence) e.weight /= sum;
  return evidence;
}

/// The first of `all`, with what is left of certainty.
Detection most_likely(const std::vector<Detection>& all, const DetectionModels::Data& data) {
  auto evidence = weighed(all, data);
  Detection best = evidence.front().pose;
  best.certainty = evidence.front().weight;
  std::stable_sort(evidence.begin() + 1, evidence.end(),
                   [](const Evidence& a, const Evidence& b) { return a.weight > b.weight; });
  for (const auto& e : std::span(evidence).subspan(1))
    if (e.weight > kNegligible) best.alternatives.push_back({e.pose.T_C_O, e.weight, e.pose.stone});
  return best;
}

}  // namespace

std::vector<std::vector<StoneIndex>> models_of_similar_shape(std::span<const DetectionModel> models) {
  std::vector<Eigen::Array3d> logarithms;
  for (const auto& model : models) logarithms.emplace_back(extents(model).array().log());
  std::vector<std::vector<StoneIndex>> rivals(models.size());
  for (std::size_t i = 0; i < models.size(); ++i)
    for (std::size_t k = 0; k < models.size(); ++k)
      if (i != k && (logarithms[i] - logarithms[k]).abs().maxCoeff() < kSimilarExtents)
        rivals[i].emplace_back(k);
  return rivals;
}

std::vector<Detection> among_alternatives(std::vector<Detection> found, const DetectionModels::Data& data,
                                          const DetectionScene& scene, const DetectionOptions& options,
                                          std::span<const KnownStone> known) {
  for (auto& d : found) {
    const DetectionModel& model = at(data.models, d.stone);
    const auto rivals = rivals_at(d, data, scene, options, known);
    if (symmetries_of(model).empty() && rivals.empty()) continue;
    std::vector<KnownStone> others;
    for (const auto& other : found)
      if (&other != &d) others.push_back({other.stone, other.T_C_O});
    const DetectionScene alone = without_stones(scene, data, others);
    auto all = judged_alternatives(d, model, alone);
    if (all.empty()) continue;
    for (const auto& rival : rivals) {
      const auto more = judged_alternatives(rival, at(data.models, rival.stone), alone);
      all.insert(all.end(), more.begin(), more.end());
    }
    d = most_likely(all, data);
  }
  return found;
}

}  // namespace stonestack::detection
