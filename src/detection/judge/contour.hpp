#pragma once
#include "detection/judge/draw_model.hpp"
#include "detection/scene/preprocess.hpp"

namespace stonestack::detection {

/// Tally of the image along the outline of a drawn model.
struct ContourTally {
  double seen = 0;  ///< places on the outline with a depth on both sides, neither explained by known stones
  double goes_on = 0;  ///< of these: the seen surface goes on smoothly where the model ends
};

/// A stone's outline is an edge or a crease of what is seen. Where the surface goes on across it, a larger
/// stone is seen, of which the model fits a part: flat stones lie in each other's faces without a pixel that
/// contradicts.
[[nodiscard]] ContourTally compare_contour(const SeenView& view, const DrawnModel& drawn);

}  // namespace stonestack::detection
