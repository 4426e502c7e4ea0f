#include "detection/features/surface_field.hpp"

#include <algorithm>
#include <cmath>

#include "stonestack/core/error.hpp"

namespace stonestack::detection {

SurfaceField::SurfaceField(std::span<const Eigen::Vector3f> points, float cell, float band)
    : inverse_cell_(1.0F / cell) {
  require(!points.empty(), "a surface field needs points");
  Eigen::AlignedBox3f box;
  for (const auto& p : points) box.extend(p);
  origin_ = box.min() - Eigen::Vector3f::Constant(band);
  const Eigen::Array3f extent = box.sizes().array() + 2.0F * band;
  require((extent < 400.0F * cell).all(), "model of ", extent.maxCoeff(), " m is too large for cells of ",
          cell, " m");
  size_ = (extent * inverse_cell_).ceil().cast<int>() + 1;
  limit_ = size_.cast<float>();
  const auto cells = static_cast<std::size_t>(size_.prod());
  nearest_.assign(cells, -1);
  std::vector<float> best(cells, band * band);
  const auto index = [&](const Eigen::Array3i& at) {
    return static_cast<std::size_t>((at.z() * size_.y() + at.y()) * size_.x() + at.x());
  };
  const auto middle = [&](const Eigen::Array3i& at) -> Eigen::Vector3f {
    return origin_ + cell * (at.cast<float>() + 0.5F).matrix();
  };
  // Vector distance propagation (Danielsson 1980), from the samples outwards: what is nearest to a cell is
  // offered to its neighbours, until none of them gets any nearer.
  std::vector<Eigen::Array3i> front, next;
  std::vector<char> waits(cells, 0);
  const auto offer = [&](const Eigen::Array3i& cell_at, std::int32_t k) {
    const Eigen::Array3i low = (cell_at - 1).max(0), high = (cell_at + 1).min(size_ - 1);
    Eigen::Array3i at;
    for (at.z() = low.z(); at.z() <= high.z(); ++at.z())
      for (at.y() = low.y(); at.y() <= high.y(); ++at.y())
        for (at.x() = low.x(); at.x() <= high.x(); ++at.x()) {
          const std::size_t i = index(at);
          if (nearest_[i] == k) continue;
          const float d2 = (middle(at) - points[static_cast<std::size_t>(k)]).squaredNorm();
          if (!(d2 < best[i])) continue;
          best[i] = d2, nearest_[i] = k;
          if (waits[i] == 0) waits[i] = 1, next.push_back(at);
        }
  };
  for (std::size_t k = 0; k < points.size(); ++k)
    offer(((points[k] - origin_).array() * inverse_cell_).cast<int>(), static_cast<std::int32_t>(k));
  while (!next.empty()) {
    front.swap(next);
    next.clear();
    for (const auto& at : front) waits[index(at)] = 0;
    for (const auto& at : front) offer(at, nearest_[index(at)]);
  }
}

}  // namespace stonestack::detection
