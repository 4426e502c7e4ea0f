#pragma once
#include <vector>

#include "detection/hypotheses/candidates.hpp"

namespace stonestack::detection {

/// Demand on a pose that is to be taken.
enum class Demand {
  kLikely,   ///< after everything has been tried
  kCertain,  ///< before: a wrong pose takes the surface of the right stone away
};

/// The score that a detection needs in a scene: the more, the less noisy the depths are where it lies, and
/// the less of the model it shows; with the paper's method the inlier ratio.
[[nodiscard]] double wanted_score(const Detection& d, const DetectionScene& scene,
                                  const DetectionOptions& options, Demand demand);

/// Enough for a detection: the wanted score and some surface, or the paper's inlier ratio.
[[nodiscard]] bool acceptable(const Detection& d, const DetectionScene& scene,
                              const DetectionOptions& options, Demand demand);

/// Takes acceptable candidates in order of worth, each model at most as often as `missing` names it, each
/// only if what it explains is mostly still free. Indices into `candidates`, best first.
[[nodiscard]] std::vector<std::size_t> without_conflicts(const std::vector<Candidate>& candidates,
                                                         const std::vector<StoneIndex>& missing,
                                                         const DetectionScene& scene,
                                                         const DetectionOptions& options, Demand demand);

/// Returns the final poses that remain when each must show some surface, and explain mostly what none of more
/// worth explains: poses move after they were accepted.
[[nodiscard]] std::vector<Detection> without_doubles(const std::vector<Detection>& found,
                                                     const DetectionModels::Data& data,
                                                     const DetectionScene& scene,
                                                     const DetectionOptions& options);

}  // namespace stonestack::detection
