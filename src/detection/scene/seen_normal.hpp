#pragma once
#include "stonestack/geometry/depth_image.hpp"

namespace stonestack::detection {

/// Normal in the camera frame, towards the camera, of the seen surface at a pixel, from pixels a few steps
/// away; zero where there is an edge or a hole.
[[nodiscard]] Eigen::Vector3d seen_normal(const DepthImage& depth, int u, int v);

}  // namespace stonestack::detection
