#pragma once
#include "stonestack/core/error.hpp"
#include "stonestack/modelling/model_objects.hpp"

namespace stonestack::modelling {

/// Throws InvalidArgument for lengths of which no volume and no surface can be made.
inline void require_usable(const ModellingOptions& options) {
  require(
      options.voxel > 0.0 && options.truncation >= options.voxel && options.facet > 0.0,
      "a model takes cells above 0, a truncation of one cell at least, and triangles above 0; got cells of ",
      options.voxel, " m, a truncation of ", options.truncation, " m, triangles of ", options.facet, " m");
}

}  // namespace stonestack::modelling
