#pragma once
#include <Eigen/Geometry>
#include <string>

#include "stonestack/core/rooms.hpp"

#pragma GCC visibility push(default)

namespace stonestack::geometry {

/// A rigid transform. The name states its frames: `T_A_B` maps B-coordinates to A, `p_A = T_A_B *
/// p_B`; inner letters cancel. The letters, fixed once for the whole project:
///
///   W world: z up, origin on the table (z = 0 is the table plane)
///   R robot base, as in the URDF (`base_link`)
///   F flange (`tool0` of the URDF: z out of the flange)
///   T tool tip: between the finger tips, z out of the gripper, x the closing direction
///   C camera, optical: z forward, x right, y down
///   O stone, the frame of its mesh;  M stone, at its centre of mass, axes of O
using Pose = Eigen::Isometry3d;

/// Difference of two poses of one frame.
struct PoseDifference {
  double translation = 0.0;  ///< between the origins [m]
  double angle = 0.0;        ///< in [0, pi] [rad]
};
[[nodiscard]] PoseDifference difference(const Pose& a, const Pose& b);

/// Rotation (need not be unit length; throws InvalidArgument when its length is below 1e-6) and translation.
[[nodiscard]] Pose make_pose(const Eigen::Vector3d& translation, const Eigen::Quaterniond& rotation);
[[nodiscard]] Pose make_pose(const Eigen::Vector3d& translation);
/// Linear in translation, spherical in rotation; `s` in [0, 1].
[[nodiscard]] Pose interpolate(const Pose& a, const Pose& b, double s);
/// Returns the pose with an orthonormal rotation (removes drift of repeated products).
[[nodiscard]] Pose orthonormal(const Pose& pose);
/// True if every number is finite and the rotation is orthonormal with determinant +1, to 1e-6.
[[nodiscard]] bool is_valid(const Pose& pose);
/// "{x: 0.1, y: 0, z: 0.2, qx: 0, qy: 0, qz: 0, qw: 1}": how a pose stands in every file (flow YAML,
/// near-JSON). qw >= 0.
[[nodiscard]] std::string to_text(const Pose& pose);

/// {p : normal . p = offset}, normal of unit length.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit normal of the plane
  double offset = 0.0;                                ///< [m]
  /// Signed distance [m] of a point to the plane, positive on the side of the normal.
  [[nodiscard]] double distance(const Eigen::Vector3d& p) const { return normal.dot(p) - offset; }
};

}  // namespace stonestack::geometry

#pragma GCC visibility pop
