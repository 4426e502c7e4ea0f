#include "detection/scene/plane_outline.hpp"

#include <algorithm>

namespace stonestack::detection {

PlaneOutline::PlaneOutline(const Plane& plane, std::span<const Eigen::Vector3d> points) : plane_(plane) {
  axes_.row(0) = plane.normal.unitOrthogonal().transpose();
  axes_.row(1) = plane.normal.cross(axes_.row(0).transpose()).transpose();
  std::vector<Eigen::Vector2d> flat;
  for (const auto& p : points) flat.emplace_back(axes_ * p);
  hull_ = convex_hull(std::move(flat));
}

double PlaneOutline::margin(const Eigen::Vector3d& p) const {
  return geometry::margin(hull_, axes_ * p);
}

double PlaneOutline::length() const {
  double longest = 0.0;
  for (const auto& a : hull_)
    for (const auto& b : hull_) longest = std::max(longest, (a - b).norm());
  return longest;
}

double PlaneOutline::area() const {
  return hull_.size() < 3 ? 0.0 : geometry::area(hull_);
}

}  // namespace stonestack::detection
