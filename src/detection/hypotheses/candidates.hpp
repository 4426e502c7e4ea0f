#pragma once
#include <optional>
#include <span>
#include <vector>

#include "detection/features/consistency.hpp"
#include "detection/features/models.hpp"
#include "detection/hypotheses/refine.hpp"
#include "detection/judge/verify.hpp"

namespace stonestack::detection {

struct ModelMemory;

inline constexpr std::size_t kKeptPoses = 5;  ///< of the coarsely refined ones, unless they tie

/// A refined pose of one model that the image does not refute.
struct Candidate {
  Detection detection;
  std::vector<SeenPixel> pixels;  ///< that it explains, on the drawn raster
  ScoreLosses lost{};             ///< what the score lacks, by what contradicts
};

/// How far [m] seen surface may lie off a model at a pose, along its normal: noisier depths are judged by
/// wider tolerances.
[[nodiscard]] double tolerance(const DetectionModel& model, const Pose& T_C_O, const DetectionScene& scene);

/// Refines hypotheses coarsely, keeps the most likely few that differ, refines these finely and verifies
/// them (`kept_poses`, more if they tie). Best score first; nothing below half the accept score. What
/// `memory` knows from earlier turns of the same search is not computed again, and what is new goes into it.
[[nodiscard]] std::vector<Candidate> judge_hypotheses(const DetectionModel& model, StoneIndex stone,
                                                      std::span<const Hypothesis> hypotheses,
                                                      const DetectionScene& scene,
                                                      const DetectionOptions& options,
                                                      std::size_t kept_poses = kKeptPoses,
                                                      ModelMemory* memory = nullptr);

/// The pixels that a model at a pose explains.
[[nodiscard]] std::vector<SeenPixel> explained_pixels(const DetectionModel& model, const Pose& T_C_O,
                                                      const DetectionScene& scene);

/// The fine refinement and the verdict alone.
[[nodiscard]] std::optional<Candidate> judge_pose(const DetectionModel& model, StoneIndex stone,
                                                  const Pose& T_C_O, const DetectionScene& scene,
                                                  double hidden_weight);

}  // namespace stonestack::detection
