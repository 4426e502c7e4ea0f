#pragma once
#include <Eigen/Core>
#include <algorithm>

#include "stonestack/core/rooms.hpp"

/// Private to motion: exact distances of a line segment, squared, without allocation. The short ones are
/// inline: a collision check asks hundreds of them.
namespace stonestack::motion {

struct Segment {
  Eigen::Vector3d a, b;
};

/// An axis-aligned box as plain numbers: what a check asks first, and most often.
struct Bounds {
  Eigen::Vector3d low, high;
};
[[nodiscard]] inline Bounds bounds(const Segment& s) {
  return {s.a.cwiseMin(s.b), s.a.cwiseMax(s.b)};
}
/// True if more than `distance` lies between the two along some axis.
[[nodiscard]] inline bool apart(const Bounds& a, const Bounds& b, double distance) {
  return a.low.x() - b.high.x() > distance || b.low.x() - a.high.x() > distance ||
         a.low.y() - b.high.y() > distance || b.low.y() - a.high.y() > distance ||
         a.low.z() - b.high.z() > distance || b.low.z() - a.high.z() > distance;
}

[[nodiscard]] inline double squared_distance(const Segment& s, const Eigen::Vector3d& p) {
  const Eigen::Vector3d along = s.b - s.a;
  const Eigen::Vector3d to = p - s.a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp(to.dot(along) / length2, 0.0, 1.0) : 0.0;
  return (to - t * along).squaredNorm();
}

[[nodiscard]] inline double squared_distance(const Segment& s, const Segment& t) {
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

/// To a solid axis-aligned box; 0 inside.
[[nodiscard]] double squared_distance_to_box(const Segment& s, const Eigen::Vector3d& low,
                                             const Eigen::Vector3d& high);

}  // namespace stonestack::motion
