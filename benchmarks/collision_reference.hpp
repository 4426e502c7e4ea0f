#pragma once
#include <vector>

#include "motion/collision.hpp"
#include "rooms.hpp"

namespace stonestack::bench {

/// Judges configurations as CollisionChecker does, by another method: link poses from the kinematics, every
/// pair by CGAL's Polytope_distance_d in exact arithmetic (a quadratic program over the vertices, Gaertner
/// and Schoenherr). Slow.
class CollisionReference {
 public:
  CollisionReference(const PlanningScene& scene, const CollisionRules& rules);
  /// Smallest distance minus padding over all pairs, m; exact where it is below `near`. Stops at the
  /// first pair that is clearly (`near`) too close.
  [[nodiscard]] double min_gap(const Joints& q, double near) const;

 private:
  struct Shape {
    int link = 0;
    bool gripper = false;
    std::vector<Eigen::Vector3d> points;  ///< in the link's frame
    double radius = 0.0;
  };
  const PlanningScene& scene_;
  CollisionRules rules_;
  std::vector<Shape> movers_;
  std::vector<std::vector<Eigen::Vector3d>> obstacles_R_;
};

/// Distance between the convex hulls of two sets of points, m; 0 where they overlap.
[[nodiscard]] double hull_gap(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b);

}  // namespace stonestack::bench
