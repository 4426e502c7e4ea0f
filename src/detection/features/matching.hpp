#pragma once
#include <vector>

#include "detection/features/models.hpp"

namespace stonestack::detection {

/// A keypoint of the scene that may be a keypoint of the model.
struct Correspondence {
  int scene = -1;
  int model = -1;
  float distance = 0.0F;  ///< squared, in descriptor space
};

/// The `neighbours` nearest model descriptors of every scene descriptor, nearest pair first. Exact: a dense
/// product is faster than a tree in hundreds of dimensions.
[[nodiscard]] std::vector<Correspondence> match_features(const Features& scene, const Features& model,
                                                         int neighbours);

/// Matches features by a kd-tree in descriptor space (FLANN through PCL, exact), as the paper has it.
[[nodiscard]] std::vector<Correspondence> match_features_kdtree(const Features& scene, const Features& model,
                                                                int neighbours);

/// Sorts by distance, then by keypoint.
void nearest_first(std::vector<Correspondence>& matches);

}  // namespace stonestack::detection
