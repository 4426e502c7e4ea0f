#pragma once
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>

#include <memory>
#include <vector>

#include "motion/collision/segment.hpp"
#include "stonestack/geometry/pose.hpp"

/// Private to motion: convex shapes and their distance, by Bullet's GJK on raw shapes (no world, no margin).
namespace stonestack::motion {

/// A convex point set with its bounds, in some frame. A capsule is the hull of its two ends with a radius.
struct ConvexCore {
  std::vector<Eigen::Vector3d> points;
  double radius = 0.0;  ///< around the hull [m]
  Segment axis;         ///< with `reach` a capsule around hull and radius
  double reach = 0.0;   ///< [m]
  std::unique_ptr<btConvexHullShape> hull;
};
[[nodiscard]] ConvexCore make_core(std::vector<Eigen::Vector3d> points, double radius);

[[nodiscard]] btTransform to_bullet(const Pose& T);

/// Distance between the two hulls, radii not regarded: negative is the depth of overlap when `depth` is
/// asked for, else any overlap (and what GJK cannot decide) is 0.
[[nodiscard]] double hull_distance(const ConvexCore& a, const btTransform& T_R_a, const ConvexCore& b,
                                   const btTransform& T_R_b, bool depth = false);

}  // namespace stonestack::motion
