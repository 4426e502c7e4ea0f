#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "stonestack/core/rooms.hpp"

namespace stonestack::search {

/// Height where a raster has no surface.
inline constexpr float kNoSurface = -1e6F;

/// Heights of a surface at the nodes `centre + cell * (i, j)`, |i|, |j| <= half; metres.
struct HeightRaster {
  HeightRaster(const Eigen::Vector2d& centre, double cell, int half);

  Eigen::Vector2d centre;
  double cell;
  int half;
  int stride;            ///< 2 half + 1
  std::vector<float> z;  ///< row by row, j slow

  [[nodiscard]] int index(int i, int j) const { return (j + half) * stride + i + half; }
  [[nodiscard]] Eigen::Vector2d node(int k) const {
    return centre + cell * Eigen::Vector2d(k % stride - half, k / stride - half);
  }
};

/// How the corners of triangles go round, seen from above. The highest of a closed surface are those that go
/// round counterclockwise, or clockwise once its heights are negated.
enum class Winding { kAny, kCounterclockwise, kClockwise };

/// Raises the raster to the surface of triangles where that is higher. A triangle steeper than a right angle
/// has no height and is skipped, and so are those that go round otherwise than `which`.
void raise_to(HeightRaster& raster, std::span<const Eigen::Vector3d> vertices,
              std::span<const Eigen::Vector3i> faces, Winding which = Winding::kAny);

}  // namespace stonestack::search
