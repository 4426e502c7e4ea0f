#pragma once
// The only include of Bullet: the double precision build, with its warnings disabled.
#include <btBulletDynamicsCommon.h>

#include <Eigen/Geometry>

#include "stonestack/geometry/pose.hpp"

static_assert(sizeof(btScalar) == 8, "link Bullet's double precision build (pkg-config bullet-float64)");

namespace stonestack::physics {

[[nodiscard]] inline btVector3 to_bullet(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}
[[nodiscard]] inline Eigen::Vector3d to_eigen(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}
[[nodiscard]] inline Eigen::Matrix3d to_eigen(const btMatrix3x3& m) {
  Eigen::Matrix3d out;
  for (int i = 0; i < 3; ++i) out.row(i) = to_eigen(m.getRow(i));
  return out;
}
[[nodiscard]] inline btTransform to_bullet(const Pose& pose) {
  const Eigen::Quaterniond q(pose.linear());
  return btTransform(btQuaternion(q.x(), q.y(), q.z(), q.w()),
                     to_bullet(Eigen::Vector3d(pose.translation())));
}
[[nodiscard]] inline Pose to_eigen(const btTransform& t) {
  Pose pose = Pose::Identity();
  pose.linear() = to_eigen(t.getBasis());
  pose.translation() = to_eigen(t.getOrigin());
  return pose;
}

}  // namespace stonestack::physics
