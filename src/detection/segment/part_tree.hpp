#pragma once
#include <vector>

#include "detection/segment/object_surface.hpp"

namespace stonestack::detection {

/// Parts of the shown surface between its grooves.
struct SurfaceParts {
  std::vector<int> label;   ///< a pixel each: 0 .., or -1 for what is no object's
  std::vector<int> pixels;  ///< of each part
};

/// Over-segments the surface by watershed of the groove depths (Meyer's flooding from one marker a cell of
/// 8 x 8 pixels), then merges neighbours, those first between which the boundary is weakest. Cost of a merge:
/// mean groove depth along the boundary, less an allowance that falls with the square root of the smaller
/// one's pixels, because short boundaries are noise. Merging ends at `kPartCost`. Parts of fewer than
/// `fewest` pixels are dropped.
[[nodiscard]] SurfaceParts split_surface(const ObjectSurface& surface, int fewest);

}  // namespace stonestack::detection
