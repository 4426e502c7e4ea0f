#pragma once
#include <vector>

#include "report/picture.hpp"
#include "stonestack/geometry/depth_image.hpp"

namespace stonestack::report {

/// Sets a pixel to a colour of parts 0..1; nothing happens outside the picture.
void set_pixel(Picture& picture, int x, int y, const Eigen::Vector3d& colour);

/// Brightness of each pixel of a depth image: 0.85 for the nearest to 0.35 for the farthest, 0 without a
/// depth.
[[nodiscard]] std::vector<double> brightness_of(const DepthImage& image);

}  // namespace stonestack::report
