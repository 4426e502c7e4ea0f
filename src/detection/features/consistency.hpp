#pragma once
#include <span>
#include <vector>

#include "detection/features/matching.hpp"

namespace stonestack::detection {

/// A pose that may be right, and how much speaks for it.
struct Hypothesis {
  Pose T_C_O = Pose::Identity();
  double support = 0.0;  ///< correspondences, or a share; comparable within one source only
};

/// How correspondences are grouped.
struct ConsistencyOptions {
  double size = 0.008;        ///< how much the distances of two points may differ between scene and model [m]
  double normal_angle = 0.6;  ///< how much the angles of their normals may differ [rad]
  int fewest = 5;             ///< correspondences in a group
  int best = 30;              ///< hypotheses at most, largest groups first
};

/// Geometric consistency (Chen and Bhanu 2004): from the best correspondence on, each collects those that
/// keep the distances to all collected ones. Distances and normal angles cannot distinguish a set from its
/// mirror image, so a group counts only if the rigid motion that fits it best leaves less than `size` between
/// its points.
[[nodiscard]] std::vector<Hypothesis> consistent_groups(std::span<const Correspondence> matches,
                                                        const Features& scene, const Features& model,
                                                        const ConsistencyOptions& options);

}  // namespace stonestack::detection
