#pragma once
#include <Eigen/Geometry>

#include "stonestack/core/rooms.hpp"

#pragma GCC visibility push(default)

namespace stonestack::geometry {

/// {p : normal . p = offset}, normal of unit length.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 0.0;  ///< [m]
  [[nodiscard]] double distance(const Eigen::Vector3d& p) const { return normal.dot(p) - offset; }
};

}  // namespace stonestack::geometry

#pragma GCC visibility pop
