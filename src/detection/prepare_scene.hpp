#pragma once
#include "detection/features/models.hpp"

namespace stonestack::detection {

/// Takes out of a scene what cannot be a wanted stone: known stones, and, where the table is not known,
/// planes larger than any model.
[[nodiscard]] DetectionScene prepare_scene(DetectionScene scene, const DetectionModels::Data& data,
                                           const DetectionOptions& options, const SceneKnowledge& known);

}  // namespace stonestack::detection
