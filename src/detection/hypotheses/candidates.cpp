#include "detection/hypotheses/candidates.hpp"

#include <algorithm>
#include <cmath>

#include "detection/constants.hpp"
#include "detection/hypotheses/search_memory.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::detection {
namespace {

constexpr int kCoarsePoints = 200;  // per pose: enough to fall into the basin
constexpr int kFinePoints = 3000;
constexpr std::size_t kMaxKept = 24;        // poses that nothing sets apart: a cube has as many
constexpr double kNearTie = 0.04;           // of the coarse score
constexpr double kSameTranslation = 0.006;  // m, rad: two coarse poses this near are one
constexpr double kSameAngle = 0.10;
constexpr double kNoiseTolerance = 4.0;   // standard deviations
constexpr double kShapeTolerance = 0.12;  // of the model's radius: with more, other shapes fit as well
constexpr double kHiddenWeight =
    0.1;  // of a pixel that something unknown hides: stones may be hidden by three quarters

/// A coarse pose and its score, best first.
struct Coarse {
  Pose T_C_O;
  double score;
};

RefineOptions coarse_refinement() {
  return {8, 1.3 * kIcpGate, 0.5 * kIcpGate, 0.003, 0.4};
}

RefineOptions fine_refinement() {
  return {15, 0.6 * kIcpGate, 0.004, 0.0015, 0.6};
}

Coarse coarse_pose(const DetectionModel& model, const Pose& T_C_O, const DetectionScene& scene,
                   PointsAround& around) {
  const auto near =
      points_near(model, T_C_O, scene.surface, kIcpGate, kCoarsePoints, around.of(T_C_O, kIcpGate));
  const Refined refined = refine_pose(model, T_C_O, scene.surface, near, coarse_refinement());
  const VerifyOptions loose{2.0 * tolerance(model, refined.T_C_O, scene), kHiddenWeight, 0.025, 300};
  return {refined.T_C_O,
          verify_pose(model, refined.T_C_O, scene, loose, around.of(refined.T_C_O, kBesideModel)).score};
}

std::vector<Coarse> coarse_poses(const DetectionModel& model, std::span<const Hypothesis> hypotheses,
                                 const DetectionScene& scene, std::size_t max, ModelMemory* memory) {
  std::vector<Coarse> poses;
  PointsAround around(model, scene.surface);
  for (const auto& h : hypotheses) {
    throw_if_interrupted();
    const auto* known = memory != nullptr ? memory->coarse.find(model, h.T_C_O, scene) : nullptr;
    const Coarse pose = known != nullptr ? Coarse{known->T_C_O_last, known->verdict}
                                         : coarse_pose(model, h.T_C_O, scene, around);
    if (memory != nullptr && known == nullptr)
      memory->coarse.keep(model, h.T_C_O, pose.T_C_O, scene, pose.score);
    if (pose.score > -0.9) poses.push_back(pose);
  }
  std::stable_sort(poses.begin(), poses.end(),
                   [](const Coarse& a, const Coarse& b) { return a.score > b.score; });
  std::vector<Coarse> kept;
  for (const auto& pose : poses) {
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const Coarse& k) {
      const PoseDifference d = difference(k.T_C_O, pose.T_C_O);
      return d.translation < kSameTranslation && d.angle < kSameAngle;
    });
    if (known) continue;
    const bool tie = pose.score > poses.front().score - kNearTie;
    if (kept.size() >= (tie ? kMaxKept : max)) break;
    kept.push_back(pose);
  }
  return kept;
}

}  // namespace

double tolerance(const DetectionModel& model, const Pose& T_C_O, const DetectionScene& scene) {
  const double noisy = kNoiseTolerance * noise_at(scene, (T_C_O * model.centre).z());
  return std::max(kVerifyTolerance, std::min(noisy, kShapeTolerance * model.radius));
}

Refined refine_finely(const DetectionModel& model, const Pose& T_C_O, const DetectionScene& scene) {
  const auto near = points_near(model, T_C_O, scene.surface, kIcpGate, kFinePoints);
  return refine_pose(model, T_C_O, scene.surface, near, fine_refinement());
}

std::optional<Candidate> judge_refined(const DetectionModel& model, StoneIndex stone, const Refined& refined,
                                       const DetectionScene& scene, double hidden_weight) {
  if (refined.correspondences == 0 || !is_valid(refined.T_C_O)) return {};
  VerifyOptions strict{tolerance(model, refined.T_C_O, scene), hidden_weight};
  strict.keep_pixels = strict.contour = true;
  Verdict verdict = verify_pose(model, refined.T_C_O, scene, strict);
  Candidate candidate;
  candidate.detection.stone = stone;
  candidate.detection.T_C_O = refined.T_C_O;
  candidate.detection.score = verdict.score;
  candidate.detection.inlier_ratio = verdict.inlier_ratio;
  candidate.detection.visible = verdict.visible;
  candidate.pixels = std::move(verdict.pixels);
  candidate.lost = verdict.lost;
  return candidate;
}

std::optional<Candidate> judge_pose(const DetectionModel& model, StoneIndex stone, const Pose& T_C_O,
                                    const DetectionScene& scene, double hidden_weight) {
  return judge_refined(model, stone, refine_finely(model, T_C_O, scene), scene, hidden_weight);
}

std::vector<SeenPixel> explained_pixels(const DetectionModel& model, const Pose& T_C_O,
                                        const DetectionScene& scene) {
  VerifyOptions strict{tolerance(model, T_C_O, scene), kHiddenWeight};
  strict.keep_pixels = true;
  return verify_pose(model, T_C_O, scene, strict).pixels;
}

std::vector<Candidate> judge_hypotheses(const DetectionModel& model, StoneIndex stone,
                                        std::span<const Hypothesis> hypotheses, const DetectionScene& scene,
                                        const DetectionOptions& options, std::size_t kept_poses,
                                        ModelMemory* memory) {
  std::vector<Candidate> candidates;
  for (const auto& pose : coarse_poses(model, hypotheses, scene, kept_poses, memory)) {
    if (const auto* known = memory != nullptr ? memory->fine.find(model, pose.T_C_O, scene) : nullptr) {
      if (known->verdict) candidates.push_back(*known->verdict);
      continue;
    }
    const Refined refined = refine_finely(model, pose.T_C_O, scene);
    auto candidate = judge_refined(model, stone, refined, scene, kHiddenWeight);
    const bool kept =
        options.method == "paper" || (candidate && candidate->detection.score > 0.5 * options.accept_score);
    if (!kept) candidate.reset();
    if (memory != nullptr) memory->fine.keep(model, pose.T_C_O, refined.T_C_O, scene, candidate);
    if (candidate) candidates.push_back(std::move(*candidate));
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.detection.score > b.detection.score;
  });
  return candidates;
}

}  // namespace stonestack::detection
