#include "detection/features/keypoints.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace stonestack::detection {

std::vector<int> voxel_keypoints(const SurfacePoints& surface, float spacing) {
  const auto key = [&](const Eigen::Vector3f& p) {
    const auto part = [&](float x) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x / spacing)) + 1048576) &
             0x1FFFFFU;
    };
    return part(p.z()) << 42U | part(p.y()) << 21U | part(p.x());
  };
  std::vector<std::pair<std::uint64_t, int>> order(surface.points.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = {key(surface.points[i]), static_cast<int>(i)};
  std::sort(order.begin(), order.end());
  std::vector<int> chosen;
  for (std::size_t first = 0; first < order.size();) {
    std::size_t last = first;
    Eigen::Vector3f mean = Eigen::Vector3f::Zero();
    for (; last < order.size() && order[last].first == order[first].first; ++last)
      mean += surface.points[static_cast<std::size_t>(order[last].second)];
    mean /= static_cast<float>(last - first);
    int best = order[first].second;
    for (std::size_t i = first; i < last; ++i)
      if ((surface.points[static_cast<std::size_t>(order[i].second)] - mean).squaredNorm() <
          (surface.points[static_cast<std::size_t>(best)] - mean).squaredNorm())
        best = order[i].second;
    chosen.push_back(best);
    first = last;
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace stonestack::detection
