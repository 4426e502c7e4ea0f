#include "detection/describe.hpp"

#include "detection/descriptors.hpp"
#include "detection/keypoints.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack {

Features describe(const SurfacePoints& surface, const DetectionOptions& options) {
  require(options.keypoints == "voxel" || options.keypoints == "iss", "keypoints must be voxel or iss, got '",
          options.keypoints, "'");
  const std::vector<int> keypoints =
      options.keypoints == "iss" ? iss_keypoints(surface)
                                 : voxel_keypoints(surface, static_cast<float>(options.keypoint_spacing));
  if (options.descriptor == "shot") return shot_features(surface, keypoints, options.descriptor_radius);
  if (options.descriptor == "fpfh") return fpfh_features(surface, keypoints, options.descriptor_radius);
  throw InvalidArgument(concat("descriptor must be shot or fpfh, got '", options.descriptor, "'"));
}

}  // namespace stonestack
