#pragma once
#include <optional>
#include <span>

#include "stonestack/geometry/pose.hpp"

namespace stonestack::detection {

/// Returns the plane through three points, its normal towards the origin (the camera); empty where they span
/// less than 1 cm^2.
[[nodiscard]] std::optional<Plane> plane_through(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                                 const Eigen::Vector3d& c);

/// Fits `plane` to the points within `tolerance` of it by least squares, twice. Normal towards the origin.
[[nodiscard]] Plane fit_plane(std::span<const Eigen::Vector3d> points, Plane plane, double tolerance);

}  // namespace stonestack::detection
