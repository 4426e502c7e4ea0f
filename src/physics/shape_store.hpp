#pragma once
#include <memory>
#include <vector>

#include "physics/shape.hpp"

namespace stonestack::physics {

/// Part of a contact shape that follows from the scan alone, without its mass.
struct ShapeGeometry {
  SignedDistance distance;
  std::vector<SurfaceSample> samples;               ///< in O
  std::shared_ptr<const SurfaceFeatures> features;  ///< of the scan
};

/// Makes it, and keeps nothing.
[[nodiscard]] std::shared_ptr<const ShapeGeometry> make_geometry(const Mesh& scan,
                                                                 const ShapeOptions& options);
/// Makes it, or finds it: what somebody holds, or one of the last `kMaxKept` that were used. An experiment
/// asks for the same stones run after run, and the planner and the simulated world each for theirs. From any
/// thread.
[[nodiscard]] std::shared_ptr<const ShapeGeometry> shape_geometry(const Mesh& scan,
                                                                  const ShapeOptions& options);
/// Shapes of scans that never come again, so nothing of them is kept. In parallel over the list.
[[nodiscard]] std::vector<std::shared_ptr<const ContactShape>> make_passing_shapes(
    const std::vector<Stone>& stones, const ShapeOptions& options = {});
/// Six stones, coarse for the planner and fine for the simulated world: some 3 to 12 MB each.
inline constexpr std::size_t kMaxKept = 12;

}  // namespace stonestack::physics
