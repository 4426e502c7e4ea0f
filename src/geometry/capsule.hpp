#pragma once
#include <Eigen/Core>
#include <vector>

#include "stonestack/core/rooms.hpp"

/// Private: capsules, and the small ones around points.
namespace stonestack::geometry {

/// All points within `radius` of the segment from `a` to `b`; a sphere when they are the same. Metres.
struct Capsule {
  Eigen::Vector3d a, b;
  double radius = 0.0;
};

/// [m^3]
[[nodiscard]] double volume(const Capsule& capsule);
/// From the surface of the capsule, negative inside. m.
[[nodiscard]] double distance(const Capsule& capsule, const Eigen::Vector3d& p);

/// The frame's three axes and those principal ones of the points that are none of these: along them a capsule
/// around points is likely small.
[[nodiscard]] std::vector<Eigen::Vector3d> axes_of(const Eigen::Matrix3Xd& points);
/// A capsule that holds all points (at least one), with the smallest circle around them across one of
/// `axes_of`; `carefully`, the axis is tilted until no tilt makes it smaller. Not the smallest of all.
[[nodiscard]] Capsule fit_capsule(const Eigen::Matrix3Xd& points, bool carefully);

}  // namespace stonestack::geometry
