#pragma once
#include <vector>

#include "detection/scene/preprocess.hpp"

namespace stonestack::detection {

/// One point a cube of `spacing`: the one nearest to the mean of the cube's points. Indices, ascending.
[[nodiscard]] std::vector<int> voxel_keypoints(const SurfacePoints& surface, float spacing);

/// Scales of intrinsic shape signatures (Zhong 2009), as multiples of the points' spacing.
struct IssOptions {
  double salient_radius = 0.018;  ///< [m]
  double non_max_radius = 0.005;  ///< smaller finds more, measured better on smooth stones [m]
  double gamma_21 = 0.975;
  double gamma_32 = 0.975;
  int fewest_neighbours = 5;
};

/// Points whose neighbourhood varies along all three axes, most salient of their surroundings (PCL). Run on
/// evenly spaced points only: PCL sums the scatter and does not weight it by density as the paper does.
/// Indices, ascending.
[[nodiscard]] std::vector<int> iss_keypoints(const SurfacePoints& surface, const IssOptions& options = {});

}  // namespace stonestack::detection
