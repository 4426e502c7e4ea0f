#include "motion/collision/convex_core.hpp"

#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>

#include <algorithm>
#include <cmath>

#include "stonestack/core/error.hpp"

namespace stonestack::motion {
namespace {

/// A capsule around the points, along the longest side of their box.
void bound(ConvexCore& core) {
  Eigen::AlignedBox3d box;
  for (const auto& p : core.points) box.extend(p);
  Eigen::Index longest = 0;
  const double half = 0.5 * box.sizes().maxCoeff(&longest);
  double across = 0.0;
  for (Eigen::Vector3d p : core.points) {
    p -= box.center();
    p[longest] = 0.0;
    across = std::max(across, p.norm());
  }
  const Eigen::Vector3d end = std::max(0.0, half - across) * Eigen::Vector3d::Unit(longest);
  core.axis = {box.center() - end, box.center() + end};
  core.reach = 0.0;
  for (const auto& p : core.points) core.reach = std::max(core.reach, squared_distance(core.axis, p));
  core.reach = std::sqrt(core.reach) + core.radius;
}

}  // namespace

ConvexCore make_core(std::vector<Eigen::Vector3d> points, double radius) {
  require(!points.empty(), "a convex piece needs vertices");
  std::vector<btVector3> vertices;
  for (const auto& p : points) {
    require(p.allFinite(), "a convex piece has the vertex (", p.transpose(), ")");
    vertices.emplace_back(p.x(), p.y(), p.z());
  }
  ConvexCore core;
  core.points = std::move(points);
  core.radius = radius;
  bound(core);
  if (core.points.size() == 2) {  // a capsule bounds itself, whatever its direction
    core.axis = {core.points[0], core.points[1]};
    core.reach = radius;
  }
  core.hull = std::make_unique<btConvexHullShape>(&vertices[0][0], static_cast<int>(vertices.size()),
                                                  static_cast<int>(sizeof(btVector3)));
  return core;
}

btTransform to_bullet(const Pose& T) {
  const auto& R = T.linear();
  const Eigen::Vector3d p = T.translation();
  return btTransform(
      btMatrix3x3(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
      btVector3(p.x(), p.y(), p.z()));
}

double hull_distance(const ConvexCore& a, const btTransform& T_R_a, const ConvexCore& b,
                     const btTransform& T_R_b, bool depth) {
  const auto middle = [](const ConvexCore& core, const btTransform& T) {
    const Eigen::Vector3d p = 0.5 * (core.axis.a + core.axis.b);
    return T * btVector3(p.x(), p.y(), p.z());
  };
  const btVector3 guess = middle(a, T_R_a) - middle(b, T_R_b);
  btGjkEpaSolver2::sResults result;
  if (btGjkEpaSolver2::Distance(a.hull.get(), T_R_a, b.hull.get(), T_R_b, guess, result))
    return result.distance;
  if (!depth) return 0.0;
  if (!btGjkEpaSolver2::Penetration(a.hull.get(), T_R_a, b.hull.get(), T_R_b, guess, result, false))
    return 0.0;
  return -std::abs(result.distance);
}

}  // namespace stonestack::motion
