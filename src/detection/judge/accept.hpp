#pragma once
#include <vector>

#include "detection/hypotheses/candidates.hpp"

namespace stonestack::detection {

/// Enough for a detection: the score and some surface, or the paper's inlier ratio. However much is seen, the
/// score must reach `min`.
[[nodiscard]] bool acceptable(const Detection& d, const DetectionOptions& options, double min = -1.0);

/// Takes acceptable candidates in order of worth, each model at most as often as `missing` names it, each
/// only if what it explains is mostly still free. Indices into `candidates`, best first.
[[nodiscard]] std::vector<std::size_t> without_conflicts(const std::vector<Candidate>& candidates,
                                                         const std::vector<StoneIndex>& missing,
                                                         const DetectionScene& scene,
                                                         const DetectionOptions& options, double min = -1.0);

/// Returns the final poses that remain when each must show some surface, and explain mostly what none of more
/// worth explains: poses move after they were accepted.
[[nodiscard]] std::vector<Detection> without_doubles(const std::vector<Detection>& found,
                                                     const DetectionModels::Data& data,
                                                     const DetectionScene& scene,
                                                     const DetectionOptions& options);

}  // namespace stonestack::detection
