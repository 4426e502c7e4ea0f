#pragma once
#include <span>

#include "stonestack/geometry/polygon.hpp"
#include "stonestack/physics/contact.hpp"

#pragma GCC visibility push(default)

namespace stonestack::physics {

/// Support polygon S_i of a stone (paper §3.1): convex hull of its contacts in their common plane, simplified
/// (CGAL).
struct SupportPolygon {
  Eigen::Vector3d p_W_centroid = Eigen::Vector3d::Zero();  ///< C_i
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitZ();          ///< n_i: mean contact normal, upwards
  std::vector<Eigen::Vector3d> corners_W;
  double area = 0.0;    ///< A_i, m^2
  double margin = 0.0;  ///< [m] distance of the projected centre of mass (along gravity) to the nearest edge,
                        ///< negative outside
  int contacts = 0;     ///< distinct contact points that went in
};
/// From contacts collected over several steps (paper §3.2); contacts with a gap above `largest_gap` are
/// dropped, points nearer than 1 mm merged. Projection of the centre of mass is along gravity (-z).
[[nodiscard]] SupportPolygon support_polygon(std::span<const Contact> contacts,
                                             const Eigen::Vector3d& p_W_com, double largest_gap = 0.0005);

}  // namespace stonestack::physics

#pragma GCC visibility pop
