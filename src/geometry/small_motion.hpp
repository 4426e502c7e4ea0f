#pragma once
#include "stonestack/geometry/pose.hpp"

namespace stonestack::geometry {

/// Motion by `x`: a translation (m), then a rotation vector (rad).
[[nodiscard]] inline Pose small_motion(const Eigen::Matrix<double, 6, 1>& x) {
  const Eigen::Vector3d w = x.tail<3>();
  Pose move = make_pose(Eigen::Vector3d(x.head<3>()));
  if (w.norm() > 1e-15) move.rotate(Eigen::AngleAxisd(w.norm(), w.normalized()));
  return move;
}

/// Rotation vector [rad] of a rotation.
[[nodiscard]] inline Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

}  // namespace stonestack::geometry
