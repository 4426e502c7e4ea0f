#pragma once
#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "stonestack/core/rooms.hpp"

namespace stonestack::detection {

/// The nearest surface sample of a model for every cell of a grid around it: one look-up instead of a tree
/// search, which makes a registration step cost microseconds. Frame O, metres.
class SurfaceField {
 public:
  /// `points` within `band` of a query are found; cells are `cell` wide.
  SurfaceField(std::span<const Eigen::Vector3f> points, float cell, float band);

  /// Index of the sample nearest to the cell of `p`, or -1 further than about the band from all of them.
  [[nodiscard]] int nearest(const Eigen::Vector3f& p) const {
    const Eigen::Array3f at = (p - origin_).array() * inverse_cell_;
    if (!(at.minCoeff() >= 0.0F) || !(at < limit_).all()) return -1;
    const Eigen::Array3i i = at.cast<int>();
    return nearest_[static_cast<std::size_t>((i.z() * size_.y() + i.y()) * size_.x() + i.x())];
  }

 private:
  Eigen::Vector3f origin_;
  float inverse_cell_;
  Eigen::Array3i size_;
  Eigen::Array3f limit_;
  std::vector<std::int32_t> nearest_;
};

}  // namespace stonestack::detection
