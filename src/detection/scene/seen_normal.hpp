#pragma once
#include "stonestack/geometry/depth_image.hpp"

namespace stonestack::detection {

/// Reach to each side [px] of the normals of a depth image at a depth [m]: 4 px, or 6 mm where the pixels are
/// finer, as their noise is no smaller.
[[nodiscard]] int normal_span(const CameraIntrinsics& camera, double z);

/// Normal in the camera frame, towards the camera, of the seen surface at a pixel, from pixels a few steps
/// away; zero where there is an edge or a hole.
[[nodiscard]] Eigen::Vector3d seen_normal(const DepthImage& depth, int u, int v);

}  // namespace stonestack::detection
