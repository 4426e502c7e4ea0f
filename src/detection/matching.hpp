#pragma once
#include <vector>

#include "detection/models.hpp"

namespace stonestack {

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

}  // namespace stonestack
