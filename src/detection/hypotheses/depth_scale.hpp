#pragma once
#include <vector>

#include "detection/features/models.hpp"

namespace stonestack::detection {

/// By how much seen depths are too large for the stones' sizes.
struct DepthScale {
  double factor = 1.0;
  double sigma = 0.0;  ///< 0: unobservable
};

/// One scale for all stones that were found, fitted along with their poses: a wrong depth unit or focal
/// length makes all of them too large or too small. Scores hardly show it: a stone of 15 cm that is 5 %
/// too large is nowhere off by more than 4 mm.
[[nodiscard]] DepthScale fit_depth_scale(const std::vector<Detection>& found,
                                         const DetectionModels::Data& data, const DetectionScene& scene);

}  // namespace stonestack::detection
