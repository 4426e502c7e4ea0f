#include "detection/describe.hpp"

#include "detection/descriptors.hpp"
#include "detection/keypoints.hpp"
#include "detection/triangulate.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack {
namespace {

std::vector<int> choose_keypoints(const SurfacePoints& surface, const DetectionOptions& options) {
  require(options.keypoints == "voxel" || options.keypoints == "iss", "keypoints must be voxel or iss, got '",
          options.keypoints, "'");
  if (options.keypoints == "iss") return iss_keypoints(surface);
  return voxel_keypoints(surface, static_cast<float>(options.keypoint_spacing));
}

Features describe_points(const SurfacePoints& surface, const DetectionOptions& options) {
  const std::vector<int> keypoints = choose_keypoints(surface, options);
  if (options.descriptor == "shot") return shot_features(surface, keypoints, options.descriptor_radius);
  require(options.descriptor == "fpfh", "descriptor must be shot, fpfh or rops, got '", options.descriptor,
          "'");
  return fpfh_features(surface, keypoints, options.descriptor_radius);
}

Features describe_triangles(const TriangulatedSurface& mesh, const DetectionOptions& options) {
  return rops_features(mesh, choose_keypoints(mesh.surface, options), options.descriptor_radius);
}

}  // namespace

Features describe_scene(const DetectionScene& scene, const DetectionOptions& options) {
  if (options.descriptor == "rops")
    return describe_triangles(triangulate(scene, options.voxel, options.height_low, options.height_high),
                              options);
  return describe_points(scene.surface, options);
}

Features describe_model(const Mesh& mesh, const SurfacePoints& seen_like, const DetectionOptions& options) {
  // Split edges are 0.5 to 1 times the longest one: 4/3 of the voxel gives its spacing on average.
  if (options.descriptor == "rops")
    return describe_triangles(subdivide(mesh, 4.0 / 3.0 * options.voxel), options);
  return describe_points(seen_like, options);
}

DetectionOptions resolved(DetectionOptions options) {
  require(options.method == "default" || options.method == "paper", "method must be default or paper, got '",
          options.method, "'");
  if (options.method == "paper") {
    options.descriptor = "rops";
    options.sweep = false;
  }
  return options;
}

}  // namespace stonestack
