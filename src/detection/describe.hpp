#pragma once
#include "detection/models.hpp"

namespace stonestack {

/// Keypoints and descriptors that the options name, of what a scene shows. Throws InvalidArgument for an
/// unknown name.
[[nodiscard]] Features describe_scene(const DetectionScene& scene, const DetectionOptions& options);

/// The same of a model's surface: `seen_like` are its points as a camera's voxels would have them.
[[nodiscard]] Features describe_model(const Mesh& mesh, const SurfacePoints& seen_like,
                                      const DetectionOptions& options);

/// What `method` stands for: paper sets the keypoints, descriptor and hypothesis source of section 2, default
/// leaves everything as it is. Throws InvalidArgument for any other.
[[nodiscard]] DetectionOptions resolved(DetectionOptions options);

}  // namespace stonestack
