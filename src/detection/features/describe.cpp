#include "detection/features/describe.hpp"

#include "detection/constants.hpp"
#include "detection/features/descriptors.hpp"
#include "detection/features/keypoints.hpp"
#include "detection/features/triangulate.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::detection {
namespace {

std::vector<int> choose_keypoints(const SurfacePoints& surface, const DetectionOptions& options) {
  require(options.keypoints == "voxel" || options.keypoints == "iss", "keypoints must be voxel or iss, got '",
          options.keypoints, "'");
  if (options.keypoints == "iss") return iss_keypoints(surface);
  return voxel_keypoints(surface, static_cast<float>(kKeypointSpacing));
}

Features describe_points(const SurfacePoints& surface, const DetectionOptions& options) {
  const std::vector<int> keypoints = choose_keypoints(surface, options);
  if (options.descriptor == "shot") return shot_features(surface, keypoints, kDescriptorRadius);
  if (options.descriptor == "iss") return iss_features(surface, keypoints, kDescriptorRadius);
  require(options.descriptor == "fpfh", "descriptor must be shot, fpfh, iss or rops, got '",
          options.descriptor, "'");
  return fpfh_features(surface, keypoints, kDescriptorRadius);
}

Features describe_triangles(const TriangulatedSurface& mesh, const DetectionOptions& options) {
  return rops_features(mesh, choose_keypoints(mesh.surface, options), kDescriptorRadius);
}

void append(Features& all, Features&& more) {
  if (all.points.empty()) {
    all = std::move(more);
    return;
  }
  if (more.points.empty()) return;
  all.points.insert(all.points.end(), more.points.begin(), more.points.end());
  all.normals.insert(all.normals.end(), more.normals.begin(), more.normals.end());
  const Eigen::Index before = all.descriptors.rows();
  all.descriptors.conservativeResize(before + more.descriptors.rows(), Eigen::NoChange);
  all.descriptors.bottomRows(more.descriptors.rows()) = more.descriptors;
}

}  // namespace

Features describe_scene(const DetectionScene& scene, const DetectionOptions& options) {
  Features all;
  for (int view = 0; view < static_cast<int>(scene.views.size()); ++view) {
    Features one = options.descriptor == "rops"
                       ? describe_triangles(triangulate(scene, view, kVoxel, kMinHeight, kMaxHeight), options)
                       : describe_points(surface_of_view(scene, view), options);
    append(all, std::move(one));
  }
  return all;
}

Features describe_model(const Mesh& mesh, const SurfacePoints& as_seen, const DetectionOptions& options) {
  // Split edges are 0.5 to 1 times the longest one: 4/3 of the voxel gives its spacing on average.
  if (options.descriptor == "rops") return describe_triangles(subdivide(mesh, 4.0 / 3.0 * kVoxel), options);
  return describe_points(as_seen, options);
}

void require_usable(const DetectionOptions& options) {
  require(options.method == "default" || options.method == "paper", "method must be default or paper, got '",
          options.method, "'");
  require(options.matching == "exact" || options.matching == "kdtree",
          "matching must be exact or kdtree, got '", options.matching, "'");
  require(options.nearest < options.farthest, "detection.nearest must be less than detection.farthest, got ",
          options.nearest, " and ", options.farthest, " m");
}

}  // namespace stonestack::detection
