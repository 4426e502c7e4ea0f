#include "motion/segment.hpp"

#include <algorithm>
#include <array>

namespace stonestack {

double squared_distance(const Segment& s, const Eigen::Vector3d& p) {
  const Eigen::Vector3d along = s.b - s.a;
  const Eigen::Vector3d to = p - s.a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp(to.dot(along) / length2, 0.0, 1.0) : 0.0;
  return (to - t * along).squaredNorm();
}

double squared_distance(const Segment& s, const Segment& t) {
  // Ericson, Real-Time Collision Detection, 5.1.9: clamp one parameter, solve for the other, clamp again.
  const Eigen::Vector3d u = s.b - s.a;
  const Eigen::Vector3d v = t.b - t.a;
  const Eigen::Vector3d w = s.a - t.a;
  const double uu = u.squaredNorm();
  const double vv = v.squaredNorm();
  const double vw = v.dot(w);
  constexpr double kPoint = 1e-24;  // m^2: a segment this short is a point
  if (uu <= kPoint) return squared_distance(t, s.a);
  if (vv <= kPoint) return squared_distance(s, t.a);
  const double uw = u.dot(w);
  const double uv = u.dot(v);
  const double determinant = uu * vv - uv * uv;
  double x = determinant > 1e-12 * uu * vv ? std::clamp((uv * vw - uw * vv) / determinant, 0.0, 1.0) : 0.0;
  double y = (uv * x + vw) / vv;
  if (y < 0.0) {
    y = 0.0;
    x = std::clamp(-uw / uu, 0.0, 1.0);
  } else if (y > 1.0) {
    y = 1.0;
    x = std::clamp((uv - uw) / uu, 0.0, 1.0);
  }
  return (w + x * u - y * v).squaredNorm();
}

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

}  // namespace stonestack
