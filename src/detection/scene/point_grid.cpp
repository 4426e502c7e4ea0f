#include "detection/scene/point_grid.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "stonestack/core/error.hpp"

namespace stonestack::detection {

PointGrid::PointGrid(std::span<const Eigen::Vector3f> points, float cell) : points_(points), cell_(cell) {
  require(cell > 0.001F * 0.1F, "cell must be above 0.1 mm, got ", cell, " m");
  std::vector<std::uint64_t> unsorted(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) unsorted[i] = key(cell_of(points[i]));
  order_.resize(points.size());
  std::iota(order_.begin(), order_.end(), 0);
  std::sort(order_.begin(), order_.end(), [&](int a, int b) {
    const auto ka = unsorted[static_cast<std::size_t>(a)], kb = unsorted[static_cast<std::size_t>(b)];
    return ka != kb ? ka < kb : a < b;
  });
  keys_.reserve(points.size());
  for (const int i : order_) keys_.push_back(unsorted[static_cast<std::size_t>(i)]);
}

Eigen::Vector3i PointGrid::cell_of(const Eigen::Vector3f& p) const {
  // 2^20 cells a side of the origin: beyond it everything shares the outermost cell.
  return (p / cell_).array().floor().cwiseMax(-1048575.0F).cwiseMin(1048575.0F).cast<int>();
}

std::uint64_t PointGrid::key(const Eigen::Vector3i& cell) {
  const auto part = [](int c) { return static_cast<std::uint64_t>(c + 1048576); };
  return part(cell.z()) << 42U | part(cell.y()) << 21U | part(cell.x());
}

std::size_t PointGrid::first_not_below(std::uint64_t wanted) const {
  return static_cast<std::size_t>(std::lower_bound(keys_.begin(), keys_.end(), wanted) - keys_.begin());
}

}  // namespace stonestack::detection
