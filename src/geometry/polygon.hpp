#pragma once
#include <Eigen/Core>
#include <vector>

#include "stonestack/core/rooms.hpp"

namespace stonestack::geometry {

/// Simple polygon in a plane, counter-clockwise, metres.
using Polygon2 = std::vector<Eigen::Vector2d>;

/// Convex hull, counter-clockwise, no collinear vertices (Andrew's monotone chain). Fewer than three vertices
/// when the points are collinear.
[[nodiscard]] Polygon2 convex_hull(std::vector<Eigen::Vector2d> points);
[[nodiscard]] double area(const Polygon2& polygon);
[[nodiscard]] Eigen::Vector2d centroid(const Polygon2& polygon);
/// Distance to the nearest edge of a convex polygon: positive inside, negative outside. For fewer than three
/// vertices minus the distance to the point or segment.
[[nodiscard]] double margin(const Polygon2& convex, const Eigen::Vector2d& point);

}  // namespace stonestack::geometry
