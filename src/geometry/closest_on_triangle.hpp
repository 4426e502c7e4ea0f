#pragma once
#include <Eigen/Core>

#include "stonestack/core/rooms.hpp"

namespace stonestack::geometry {

/// Which part of a triangle is nearest. Corners and edges are numbered: edge k runs from corner k to k + 1.
enum class TriangleFeature { kCorner0, kCorner1, kCorner2, kEdge0, kEdge1, kEdge2, kInside };

struct ClosestOnTriangle {
  Eigen::Vector3d point;
  TriangleFeature feature;
};

/// Nearest point of the triangle (a, a + ab, a + ac) to p, by the Voronoi regions of its features (Ericson,
/// Real-Time Collision Detection, 5.1.5). The triangle has an area.
[[nodiscard]] inline ClosestOnTriangle closest_on_triangle(const Eigen::Vector3d& a,
                                                           const Eigen::Vector3d& ab,
                                                           const Eigen::Vector3d& ac,
                                                           const Eigen::Vector3d& p) {
  const Eigen::Vector3d ap = p - a;
  const double ab_a = ab.dot(ap);
  const double ac_a = ac.dot(ap);
  if (ab_a <= 0.0 && ac_a <= 0.0) return {a, TriangleFeature::kCorner0};
  const Eigen::Vector3d bp = ap - ab;
  const double ab_b = ab.dot(bp);
  const double ac_b = ac.dot(bp);
  if (ab_b >= 0.0 && ac_b <= ab_b) return {a + ab, TriangleFeature::kCorner1};
  const Eigen::Vector3d cp = ap - ac;
  const double ab_c = ab.dot(cp);
  const double ac_c = ac.dot(cp);
  if (ac_c >= 0.0 && ab_c <= ac_c) return {a + ac, TriangleFeature::kCorner2};
  // Barycentric weights of c, b and a, times twice the area squared.
  const double weight_c = ab_a * ac_b - ab_b * ac_a;
  if (weight_c <= 0.0 && ab_a >= 0.0 && ab_b <= 0.0)
    return {a + (ab_a / (ab_a - ab_b)) * ab, TriangleFeature::kEdge0};
  const double weight_b = ab_c * ac_a - ab_a * ac_c;
  if (weight_b <= 0.0 && ac_a >= 0.0 && ac_c <= 0.0)
    return {a + (ac_a / (ac_a - ac_c)) * ac, TriangleFeature::kEdge2};
  const double weight_a = ab_b * ac_c - ab_c * ac_b;
  const double along_b = ac_b - ab_b;
  const double along_c = ab_c - ac_c;
  if (weight_a <= 0.0 && along_b >= 0.0 && along_c >= 0.0)
    return {a + ab + (along_b / (along_b + along_c)) * (ac - ab), TriangleFeature::kEdge1};
  const double total = weight_a + weight_b + weight_c;
  return {a + (weight_b / total) * ab + (weight_c / total) * ac, TriangleFeature::kInside};
}

}  // namespace stonestack::geometry
