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
  const int reach = static_cast<int>(std::ceil(band * inverse_cell_));
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Eigen::Array3i centre = ((points[k] - origin_).array() * inverse_cell_).cast<int>();
    const Eigen::Array3i low = (centre - reach).max(0), high = (centre + reach).min(size_ - 1);
    for (int z = low.z(); z <= high.z(); ++z)
      for (int y = low.y(); y <= high.y(); ++y)
        for (int x = low.x(); x <= high.x(); ++x) {
          const Eigen::Vector3f middle =
              origin_ +
              cell * (Eigen::Vector3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)) +
                      Eigen::Vector3f::Constant(0.5F));
          const float d2 = (middle - points[k]).squaredNorm();
          const auto i = static_cast<std::size_t>((z * size_.y() + y) * size_.x() + x);
          if (d2 < best[i]) best[i] = d2, nearest_[i] = static_cast<std::int32_t>(k);
        }
  }
}

}  // namespace stonestack::detection
