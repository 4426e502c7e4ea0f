#pragma once
#include <optional>

#include "stonestack/geometry/depth_image.hpp"

namespace stonestack::geometry {

/// True if every depth is a whole number of counts of `unit` [m], at most 65535, up to the rounding of a
/// float: a 16-bit picture keeps the image exactly.
[[nodiscard]] bool is_depth_unit(const DepthImage& image, double unit);
/// Finds the unit [m] in which a camera has counted these depths, from the gaps between them.
/// @return empty where the depths are no counts, or too few of them are there to tell.
[[nodiscard]] std::optional<double> find_depth_unit(const DepthImage& image);
/// Finest unit [m] of 10, 20, 50 um, ... 1 mm in which 16 bits reach the farthest depth.
[[nodiscard]] double finest_depth_unit(const DepthImage& image);

}  // namespace stonestack::geometry
