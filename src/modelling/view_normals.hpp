#pragma once
#include <vector>

#include "stonestack/geometry/depth_image.hpp"

namespace stonestack::modelling {
using namespace geometry;

/// Normal of the seen surface at every pixel of a smoothed image, towards the camera; zero at edges and
/// holes.
[[nodiscard]] std::vector<Eigen::Vector3f> view_normals(const DepthImage& smooth);

/// Depth up to which a pixel and its neighbours see nothing: the least of them all; 0 where one sees nothing
/// at all.
[[nodiscard]] std::vector<float> seen_to(const DepthImage& image);

}  // namespace stonestack::modelling
