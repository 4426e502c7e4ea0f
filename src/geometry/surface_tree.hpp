#pragma once
#include <limits>
#include <memory>

#include "stonestack/geometry/mesh.hpp"

namespace stonestack::geometry {

/// The point of a mesh nearest to another point.
struct SurfacePoint {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  /// Unit pseudonormal of the nearest face, edge or vertex (Baerentzen and Aanaes 2005).
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  /// Signed distance, negative inside a closed mesh [m]; the limit when nothing is within it.
  double distance = 0.0;
  int face = -1;  ///< -1: nothing within the limit
};

/// Exact nearest-point queries to a triangle mesh (box tree). Immutable, shared between threads. Faces
/// without area are left out: their neighbours cover them.
class SurfaceTree {
 public:
  /// Throws InvalidArgument when no face has an area.
  explicit SurfaceTree(const Mesh& mesh);
  ~SurfaceTree();
  SurfaceTree(SurfaceTree&&) noexcept;
  SurfaceTree& operator=(SurfaceTree&&) noexcept;

  /// `likely_face`, e.g. the answer for a neighbouring point, makes the search faster and changes no
  /// distance.
  [[nodiscard]] SurfacePoint nearest(const Eigen::Vector3d& p,
                                     double limit = std::numeric_limits<double>::infinity(),
                                     int likely_face = -1) const;
  /// Finds the nearest points for points that lie close together, several times faster: they share one
  /// descent of the tree.
  [[nodiscard]] std::vector<SurfacePoint> nearest(const std::vector<Eigen::Vector3d>& cluster,
                                                  int likely_face = -1) const;

 private:
  struct Tree;
  std::unique_ptr<const Tree> tree_;
};

}  // namespace stonestack::geometry
