#include "geometry/polygon.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stonestack::geometry {
namespace {

double cross(const Eigen::Vector2d& u, const Eigen::Vector2d& v) {
  return u.x() * v.y() - u.y() * v.x();
}

double segment_distance(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& p) {
  const Eigen::Vector2d ab = b - a;
  const double length2 = ab.squaredNorm();
  const double s = length2 > 0.0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
  return (a + s * ab - p).norm();
}

/// Extends a chain of left turns by each point in [first, last).
template <class Iterator>
Polygon2 left_turning_chain(Iterator first, Iterator last) {
  Polygon2 chain;
  for (; first != last; ++first) {
    while (chain.size() >= 2 &&
           cross(chain.back() - chain[chain.size() - 2], *first - chain[chain.size() - 2]) <= 0.0)
      chain.pop_back();
    chain.push_back(*first);
  }
  return chain;
}

}  // namespace

Polygon2 convex_hull(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
    return p.x() < q.x() || (p.x() == q.x() && p.y() < q.y());
  });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  Polygon2 hull = left_turning_chain(points.begin(), points.end());
  const Polygon2 upper = left_turning_chain(points.rbegin(), points.rend());
  hull.pop_back();  // each chain ends where the other begins
  hull.insert(hull.end(), upper.begin(), upper.end() - 1);
  return hull;
}

double area(const Polygon2& polygon) {
  double sum = 0.0;
  for (std::size_t i = 0; i + 2 < polygon.size(); ++i)
    sum += cross(polygon[i + 1] - polygon[0], polygon[i + 2] - polygon[0]);
  return 0.5 * sum;
}

Eigen::Vector2d centroid(const Polygon2& polygon) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  if (polygon.empty()) return mean;
  for (const Eigen::Vector2d& p : polygon) mean += p / static_cast<double>(polygon.size());
  const double total = area(polygon);
  if (std::abs(total) < 1e-300) return mean;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i + 2 < polygon.size(); ++i) {
    const Eigen::Vector2d u = polygon[i + 1] - polygon[0];
    const Eigen::Vector2d v = polygon[i + 2] - polygon[0];
    moment += cross(u, v) / 6.0 * (u + v);
  }
  return polygon[0] + moment / total;
}

double margin(const Polygon2& convex, const Eigen::Vector2d& point) {
  double nearest = std::numeric_limits<double>::infinity();
  bool inside = convex.size() >= 3;
  for (std::size_t i = 0; i < convex.size(); ++i) {
    const Eigen::Vector2d& a = convex[i];
    const Eigen::Vector2d& b = convex[(i + 1) % convex.size()];
    nearest = std::min(nearest, segment_distance(a, b, point));
    inside = inside && cross(b - a, point - a) >= 0.0;
  }
  return inside ? nearest : -nearest;
}

}  // namespace stonestack::geometry
