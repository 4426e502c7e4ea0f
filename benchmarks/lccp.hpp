#pragma once
#include <vector>

#include "rooms.hpp"
#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/geometry/pose.hpp"

namespace stonestack::bench {

/// Segmentation of PCL as a baseline: locally convex connected patches (Stein et al. 2014) on supervoxels
/// (Papon et al. 2013) of the depth image's points more than `lowest` m above the table. Parameters as in
/// PCL's example, without colour.
/// @return a label a pixel, row by row: 0 where there is no object; segments of fewer than `fewest` pixels
/// are dropped.
[[nodiscard]] std::vector<int> lccp_labels(const DepthImage& image, const Plane& table_C, double lowest,
                                           int fewest);

}  // namespace stonestack::bench
