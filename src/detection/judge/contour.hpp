#pragma once
#include <span>

#include "detection/judge/draw_model.hpp"
#include "detection/scene/preprocess.hpp"

namespace stonestack::detection {

/// Tally of the image along the outline of a drawn model.
struct ContourTally {
  double all = 0;      ///< places on the outline
  double seen = 0;     ///< places on the outline where the model is seen, with a depth beyond, too, neither
                       ///< explained by known stones
  double goes_on = 0;  ///< of these: the seen surface goes on smoothly where the model ends
};

/// A stone's outline is an edge or a crease of what is seen. Where the surface goes on across it, a larger
/// stone is seen, of which the model fits a part: flat stones lie in each other's faces without a pixel that
/// contradicts. The model counts as seen within the outline where the depth is at most `reach` [m] off: what
/// stands in front of it has outlines of its own.
/// @param weights what places on each face count; empty: 1
[[nodiscard]] ContourTally compare_contour(const SeenView& view, const DrawnModel& drawn, double reach,
                                           std::span<const double> weights = {});

}  // namespace stonestack::detection
