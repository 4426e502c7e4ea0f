#pragma once
#include <Eigen/Geometry>
#include <vector>

#include "stonestack/core/rooms.hpp"

namespace stonestack::search {

/// Which sides of a stone may point down.
struct OrientationOptions {
  int directions = 160;                             ///< over the whole sphere, or the cone if that is smaller
  double max_tilt = 3.14159266;                     ///< of the stone's up axis from `up_O` [rad]
  Eigen::Vector3d up_O = Eigen::Vector3d::UnitZ();  ///< the world's up axis in O as the stone lies now
};
/// Rotations R_W_O, one for each direction on an even (Fibonacci) lattice that the tilt limit allows. The
/// lattice gets denser as the cone gets narrower, so that about as many remain (down to a sixth of the
/// sphere).
[[nodiscard]] std::vector<Eigen::Matrix3d> orientations(const OrientationOptions& options);

/// Rotation about the world's z axis.
[[nodiscard]] Eigen::Matrix3d yaw_rotation(double angle);

}  // namespace stonestack::search
