#pragma once
#include "stonestack/detection/detect_stones.hpp"

namespace stonestack::search {

/// Detects once more, among the models that `first` did not find, in what its stones leave unexplained. A
/// stone that must be there, because it carries one that was found, is accepted at a lower score.
/// @return the stones of `first` and the further ones.
[[nodiscard]] DetectionResult detect_missing(const DepthImage& image, const DetectionModels& models,
                                             const DetectionResult& first, const DetectionOptions& options);

}  // namespace stonestack::search
