#include "motion/collision/segment.hpp"

#include <algorithm>
#include <array>

namespace stonestack::motion {

double squared_distance_to_box(const Segment& s, const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  // Along the segment the squared distance is convex and made of parabolas that join where a coordinate
  // passes a face; its minimum lies in the piece where the slope changes sign.
  const Eigen::Vector3d along = s.b - s.a;
  std::array<double, 8> joints{};  // parameters, rising; the last is 1
  std::size_t count = 0;
  const auto insert = [&](double t) {
    std::size_t i = count++;
    for (; i > 0 && joints[i - 1] > t; --i) joints[i] = joints[i - 1];
    joints[i] = t;
  };
  for (int i = 0; i < 3; ++i) {
    if (along[i] == 0.0) continue;
    for (const double face : {low[i], high[i]}) {
      const double t = (face - s.a[i]) / along[i];
      if (t > 0.0 && t < 1.0) insert(t);
    }
  }
  insert(1.0);
  const auto gap = [&](double t) -> Eigen::Vector3d {
    const Eigen::Vector3d p = s.a + t * along;
    return p - p.cwiseMax(low).cwiseMin(high);
  };
  const auto slope = [&](double t) { return gap(t).dot(along); };
  double from = 0.0;
  double before = slope(from);
  if (before >= 0.0) return gap(from).squaredNorm();
  for (std::size_t i = 0; i < count; ++i) {
    const double after = slope(joints[i]);
    if (after >= 0.0) {
      const double share = before / (before - after);
      return gap(from + share * (joints[i] - from)).squaredNorm();
    }
    from = joints[i];
    before = after;
  }
  return gap(1.0).squaredNorm();
}

}  // namespace stonestack::motion
