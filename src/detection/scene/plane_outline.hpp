#pragma once
#include <span>

#include "geometry/polygon.hpp"
#include "stonestack/geometry/pose.hpp"

namespace stonestack::detection {

/// A part of a plane: what is seen of a table, or of a wall.
class PlaneOutline {
 public:
  /// The convex hull of the points, projected onto the plane. Frame of the points and of the plane.
  PlaneOutline(const Plane& plane, std::span<const Eigen::Vector3d> points);

  /// Plane of the outline.
  [[nodiscard]] const Plane& plane() const { return plane_; }
  /// Distance [m] of a point, projected onto the plane, from the outline: positive inside.
  [[nodiscard]] double margin(const Eigen::Vector3d& p) const;
  /// Longest distance [m] between two points of the outline.
  [[nodiscard]] double length() const;
  /// Area inside the outline [m^2].
  [[nodiscard]] double area() const;

 private:
  Plane plane_;
  Eigen::Matrix<double, 2, 3> axes_;  ///< unit vectors along the plane
  Polygon2 hull_;
};

}  // namespace stonestack::detection
