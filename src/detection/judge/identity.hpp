#pragma once
#include <span>
#include <vector>

#include "detection/features/models.hpp"

namespace stonestack::detection {

/// Of each model the others that are about as long, as wide and as thick.
[[nodiscard]] std::vector<std::vector<StoneIndex>> models_of_similar_shape(
    std::span<const DetectionModel> models);

/// Compares each detection with the poses that the turns of its model lead to, and with the stones of like
/// shape that may stand there instead, but for those of `known`. Takes the pose of its stone that fits best,
/// and states what is left of certainty when others fit nearly as well. Which stone it is stays as it was,
/// and so does `covariance`.
[[nodiscard]] std::vector<Detection> among_alternatives(std::vector<Detection> found,
                                                        const DetectionModels::Data& data,
                                                        const DetectionScene& scene,
                                                        const DetectionOptions& options,
                                                        std::span<const KnownStone> known);

}  // namespace stonestack::detection
