#pragma once
#include "detection/models.hpp"

namespace stonestack {

/// Keypoints and descriptors that the options name, on one surface. Throws InvalidArgument for an unknown
/// name.
[[nodiscard]] Features describe(const SurfacePoints& surface, const DetectionOptions& options);

}  // namespace stonestack
