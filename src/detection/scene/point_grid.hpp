#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "stonestack/core/rooms.hpp"

namespace stonestack::detection {

/// Points sorted into cubic cells, for queries "all points within a radius". Keeps a reference to the points.
class PointGrid {
 public:
  /// Points must be finite and within 1 km of the origin; `cell` in metres, about the radius of the queries.
  PointGrid(std::span<const Eigen::Vector3f> points, float cell);

  /// Calls visit(index, squared distance) for every point within `radius`, in a fixed order.
  template <class Visit>
  void for_each_near(const Eigen::Vector3f& p, float radius, Visit&& visit) const {
    const Eigen::Vector3i low = cell_of(p - Eigen::Vector3f::Constant(radius));
    const Eigen::Vector3i high = cell_of(p + Eigen::Vector3f::Constant(radius));
    for (int z = low.z(); z <= high.z(); ++z)
      for (int y = low.y(); y <= high.y(); ++y) {
        const std::uint64_t last = key({high.x(), y, z});
        for (auto i = first_not_below(key({low.x(), y, z})); i < keys_.size() && keys_[i] <= last; ++i) {
          const float d2 = (points_[static_cast<std::size_t>(order_[i])] - p).squaredNorm();
          if (d2 <= radius * radius) visit(order_[i], d2);
        }
      }
  }

 private:
  [[nodiscard]] Eigen::Vector3i cell_of(const Eigen::Vector3f& p) const;
  [[nodiscard]] static std::uint64_t key(const Eigen::Vector3i& cell);
  [[nodiscard]] std::size_t first_not_below(std::uint64_t key) const;

  std::span<const Eigen::Vector3f> points_;
  float cell_;
  std::vector<std::uint64_t> keys_;  ///< ascending
  std::vector<int> order_;           ///< point of each key
};

}  // namespace stonestack::detection
