#include "geometry/footprint.hpp"

namespace stonestack::geometry {

Polygon2 footprint(std::span<const Mesh> pieces, const Pose& T_W_object) {
  std::vector<Eigen::Vector2d> points;
  for (const Mesh& piece : pieces)
    for (const Eigen::Vector3d& p : piece.vertices) points.push_back((T_W_object * p).head<2>());
  return convex_hull(std::move(points));
}

}  // namespace stonestack::geometry
