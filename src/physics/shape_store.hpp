#pragma once
#include <memory>
#include <vector>

#include "stonestack/physics/shape.hpp"

namespace stonestack::physics {

/// What of a contact shape follows from the scan alone, without its mass.
struct ShapeGeometry {
  SignedDistance distance;
  std::vector<SurfaceSample> samples;               ///< in O
  std::shared_ptr<const SurfaceFeatures> features;  ///< of the scan
};

/// Makes it, or takes it from the last `kMostKept` that this process made: an experiment asks for the same
/// stones run after run, and the planner and the simulated world each for theirs. From any thread.
[[nodiscard]] std::shared_ptr<const ShapeGeometry> shape_geometry(const Mesh& scan,
                                                                  const ShapeOptions& options);
/// Some 3 to 6 MB each.
inline constexpr std::size_t kMostKept = 48;

}  // namespace stonestack::physics
