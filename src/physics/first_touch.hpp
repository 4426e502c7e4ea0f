#pragma once
#include <algorithm>
#include <cmath>

#include "physics/touch.hpp"

/// Which features of two surfaces can be the first to touch, exactly or after some motion and turn. Inline:
/// millions are asked a second.
namespace stonestack::physics {

/// Deepest distance that features measure; below it the signed distance does [m].
inline constexpr double kDeepest = 0.003;
/// Motion after which candidates are searched again [m and rad].
inline constexpr double kSlack = 0.002, kTurn = 0.02;
/// Sine: how far out of a normal cone still counts.
inline constexpr double kCone = 0.02;
/// Distance beside a face or beyond an edge's end that still counts [m].
inline constexpr double kRim = 1e-5;
/// The gap up to which candidates are kept [m].
inline constexpr double kReach = kTouchGap + kSlack;

inline bool in_face(const FaceFeature& face, const Eigen::Vector3d& p, double beyond) {
  for (int i = 0; i < 3; ++i)
    if (face.side[i].dot(p) < face.side_offset[i] - beyond) return false;
  return true;
}

/// True if vertex `v` is the first of its surroundings to meet a plane with normal `n` from above.
inline bool leads(const SurfaceFeatures& features, int v, const Eigen::Vector3d& n, double tolerance) {
  const auto i = static_cast<std::size_t>(v);
  for (int k = features.fan_begin[i]; k < features.fan_begin[i + 1]; ++k)
    if (features.fan[static_cast<std::size_t>(k)].dot(n) < -tolerance) return false;
  return true;
}

inline bool in_cone(const EdgeFeature& edge, const Eigen::Vector3d& n, double tolerance) {
  return edge.into0.dot(n) <= tolerance && edge.into1.dot(n) <= tolerance;
}

inline EdgeFeature moved(const EdgeFeature& e, const Pose& T) {
  const Eigen::Matrix3d R = T.linear();
  return {T * e.p0, T * e.p1, R * e.d, R * e.into0, R * e.into1, R * e.n_mean, e.length};
}

/// Where two edges cross, seen along their common normal.
struct Crossing {
  bool valid = false;
  double gap = 0.0;
  Eigen::Vector3d n, p_a, p_b;  ///< n from b to a
};
inline Crossing cross(const EdgeFeature& a, const EdgeFeature& b, double beyond, double cone,
                      double parallel) {
  Crossing out;
  const Eigen::Vector3d c = a.d.cross(b.d);
  const double sine = c.norm();
  if (sine < parallel) return out;
  out.n = c / sine;
  if (out.n.dot(b.n_mean - a.n_mean) < 0.0) out.n = -out.n;
  const Eigen::Vector3d r = b.p0 - a.p0;
  out.gap = -out.n.dot(r);
  if (out.gap > kReach || out.gap < -kDeepest - kSlack) return out;
  if (!in_cone(b, out.n, cone) || !in_cone(a, -out.n, cone)) return out;
  const double s = r.cross(b.d).dot(c) / (sine * sine);
  const double t = r.cross(a.d).dot(c) / (sine * sine);
  if (s < -beyond || s > a.length + beyond || t < -beyond || t > b.length + beyond) return out;
  out.p_a = a.p0 + s * a.d;
  out.p_b = b.p0 + t * b.d;
  out.valid = true;
  return out;
}

/// The point lies within `reach` of the edge.
inline bool near_edge(const Eigen::Vector3d& p, const EdgeFeature& e, double reach) {
  const double s = std::clamp((p - e.p0).dot(e.d), 0.0, e.length);
  return (p - e.p0 - s * e.d).squaredNorm() <= reach * reach;
}

/// A vertex that may touch a face.
struct VertexTouch {
  bool valid = false;
  Eigen::Vector3d p;  ///< the vertex
  double gap = 0.0;   ///< of it to the face's plane [m]; negative: penetration
};
/// Touch of vertex x of X on face y of Y, all in Y; not valid if they cannot be the first to touch, even
/// after some motion and turn.
inline VertexTouch vertex_on_face(const SurfaceFeatures& X, int x, const Pose& T_Y_X, const FaceFeature& face,
                                  double motion = 0.0, double turn = 0.0) {
  VertexTouch touch;
  touch.p = T_Y_X * X.vertices[static_cast<std::size_t>(x)];
  touch.gap = face.n.dot(touch.p) - face.offset;
  touch.valid = touch.gap <= kTouchGap + motion && touch.gap >= -kDeepest - motion &&
                in_face(face, touch.p, kRim + motion) &&
                leads(X, x, T_Y_X.linear().transpose() * face.n, kCone + turn);
  return touch;
}

/// Edges that may touch after some motion and turn; those that are nearly parallel always may.
inline bool may_cross(const EdgeFeature& a, const EdgeFeature& b, double motion, double turn) {
  const double sine = a.d.cross(b.d).norm();
  if (sine < 0.05) return true;
  const Crossing c = cross(a, b, kRim + motion / sine, kCone + turn / sine, 0.0);
  return c.valid && c.gap <= kTouchGap + motion && c.gap >= -kDeepest - motion;
}

/// The change of a relative pose moves some point within `radius` (m) by more than `motion`, or turns more
/// than `turn_limit`.
inline bool moved_enough(const Pose& before, const Pose& now, double radius, double motion,
                         double turn_limit) {
  const Eigen::Matrix3d turn = before.linear().transpose() * now.linear();
  const double angle = std::sqrt(std::max(0.0, 3.0 - turn.trace()));  // 2 sin(angle / 2) to first order
  return angle > turn_limit || (now.translation() - before.translation()).norm() + angle * radius > motion;
}

inline double radius_about_origin(const SurfaceFeatures& features) {
  return features.box.min().cwiseAbs().cwiseMax(features.box.max().cwiseAbs()).norm();
}

}  // namespace stonestack::physics
