#pragma once
#include <vector>

#include "detection/features/models.hpp"

namespace stonestack::detection {

/// Refines found stones together, the last step of a detection. Unknown are the poses, the small error of the
/// reported pose of every further view (prior: `view_shift`, `view_turn`; the table that views share), and
/// the smooth error of each depth image (prior: what its table shows, see DepthError; generalised least
/// squares). Every seen point counts for the stone that it is nearest to. Covariances are those of this
/// estimate, times `covariance_scale`^2. Poses must be right within a few millimetres already.
[[nodiscard]] std::vector<Detection> refined_together(std::vector<Detection> found,
                                                      const DetectionModels::Data& data,
                                                      const DetectionScene& scene);

}  // namespace stonestack::detection
