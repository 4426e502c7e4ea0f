#pragma once
#include <span>
#include <vector>

#include "detection/scene/preprocess.hpp"

namespace stonestack::detection {

/// How creases are found.
struct SplitOptions {
  double radius = 0.012;    ///< of the neighbourhood that decides [m]
  double concavity = 0.12;  ///< mean sine of the angle by which neighbours rise above the tangent plane
  double gap = 0.006;       ///< between points of one part [m]
  int fewest = 60;          ///< points of a part
};

/// Parts of a cluster between its creases: where stones touch, the surface is concave, while a stone is
/// convex but for its roughness. Points in creases belong to no part. Empty if the cluster has no more than
/// one part of nearly its own size.
[[nodiscard]] std::vector<std::vector<int>> split_parts(const SurfacePoints& surface,
                                                        std::span<const int> cluster,
                                                        const SplitOptions& options = {});

}  // namespace stonestack::detection
