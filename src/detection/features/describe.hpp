#pragma once
#include "detection/features/models.hpp"

namespace stonestack::detection {

/// Keypoints and descriptors that the options name, of what a scene shows. Throws InvalidArgument for an
/// unknown name.
[[nodiscard]] Features describe_scene(const DetectionScene& scene, const DetectionOptions& options);

/// Describes a model's surface: `as_seen` are its points as a camera's voxels would have them.
[[nodiscard]] Features describe_model(const Mesh& mesh, const SurfacePoints& as_seen,
                                      const DetectionOptions& options);

/// Throws InvalidArgument for a method or matching that is none, or an empty depth range.
void require_usable(const DetectionOptions& options);

}  // namespace stonestack::detection
