#pragma once
#include <vector>

#include "detection/segment/object_surface.hpp"

namespace stonestack::detection {

/// How deep each shown pixel lies in a groove: where objects touch or one stands before another, the surface
/// lies behind the chord between the points to both sides. Mean over the distances 4, 8 and 14 mm of depth
/// behind the chord over distance, in the direction of four where it is largest: sine of half the angle by
/// which two flat faces bend inwards, and 1 behind a high step. 0 for flat and convex surface; never
/// negative.
[[nodiscard]] std::vector<float> groove_depths(const ObjectSurface& surface);

/// Height of the step between two neighbouring pixels on the same scale as a groove; 0 for what a slope
/// explains.
[[nodiscard]] float step_between(const ObjectSurface& surface, std::size_t a, std::size_t b);

}  // namespace stonestack::detection
