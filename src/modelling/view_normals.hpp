#pragma once
#include <vector>

#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/geometry/depth_image.hpp"

namespace stonestack::modelling {
using namespace geometry;

/// Normal of the seen surface at every pixel of a smoothed image, towards the camera; zero at edges and
/// holes.
[[nodiscard]] std::vector<Eigen::Vector3f> view_normals(const DepthImage& smooth);

/// Normals of a raw image, smoothed first, in the bounding box of the pixels that show an object: as those of
/// the whole image, in the time of an object. Zero elsewhere.
/// @param shows a flag a pixel
[[nodiscard]] std::vector<Eigen::Vector3f> normals_where(const std::vector<char>& shows,
                                                         const DepthImage& raw,
                                                         const DetectionOptions& options);

/// Depth up to which a pixel and its neighbours see nothing: the least of them all; 0 where one sees nothing
/// at all.
[[nodiscard]] std::vector<float> seen_to(const DepthImage& image);

}  // namespace stonestack::modelling
