#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "stonestack/geometry/pose.hpp"

#pragma GCC visibility push(default)

namespace stonestack::physics {

/// The table's index where a body index is asked for.
inline constexpr int kTable = -1;

/// A point where two bodies touch.
struct Contact {
  int below = kTable;                              ///< body index or kTable
  int above = 0;                                   ///< body index; `normal` points from `below` to `above`
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();   ///< point of contact [m]
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitZ();  ///< unit normal, from `below` to `above`
  double gap = 0.0;                                ///< negative [m]: penetration
  double impulse = 0.0;                            ///< normal impulse [N s], of the last step
};

/// A rigid body for statics.
struct StaticBody {
  double mass = 0.0;                                  ///< mass, kg
  Eigen::Vector3d p_W_com = Eigen::Vector3d::Zero();  ///< centre of mass, m
};

/// Verdict on a stack of rigid bodies with Coulomb contacts.
struct Equilibrium {
  bool stands = false;  ///< true if contact forces within the friction cones balance gravity
  double margin =
      0.0;  ///< largest horizontal acceleration borne in the worst of the tested directions; 0 if it falls
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();  ///< W, unit: where that push goes
  double min_friction =
      0;  ///< smallest friction coefficient at which it stands (bisection); infinity if none up to 2
  /// Contact that fails first in the worst direction: the one whose friction limits the margin most, or,
  /// where friction does not, the one that carries most as the stack tips over it. -1: none (it falls, or
  /// free bodies).
  int weakest_contact = -1;
};

/// Options of `solve_equilibrium`.
struct EquilibriumOptions {
  double friction = 0.1;     ///< friction coefficient of all contacts
  int cone_edges = 8;        ///< generators of the inner friction cone
  int directions = 8;        ///< horizontal directions for the margin
  double torque_arm = 0.05;  ///< scale of torques against forces, m
  double tolerance = 1e-6;   ///< share of the total weight that may stay unbalanced
  bool min_friction = true;  ///< also find `min_friction` (a dozen more programmes)
};

/// Contact forces in friction cones that balance gravity: a linear programme (GLPK). `contacts` index into
/// `bodies` (kTable: the ground). Upper bound of what a stack bears (contacts may shift): ask for a margin,
/// not for feasibility. Contacts of one pair within 1 mm and 3 deg count once. A programme that the solver
/// cannot solve counts as a stack that falls.
/// @throws InvalidArgument for indices out of range, masses that are not positive, points that are not
/// finite, and friction that is negative or not finite.
[[nodiscard]] Equilibrium solve_equilibrium(std::span<const StaticBody> bodies,
                                            std::span<const Contact> contacts,
                                            const EquilibriumOptions& options = {});

/// Support polygon S_i of a stone (paper §3.1): convex hull of its contacts in their common plane, simplified
/// (CGAL).
struct SupportPolygon {
  Eigen::Vector3d p_W_centroid = Eigen::Vector3d::Zero();  ///< C_i
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitZ();          ///< n_i: mean contact normal, upwards
  std::vector<Eigen::Vector3d> corners_W;                  ///< corners in order around the polygon [m]
  double area = 0.0;                                       ///< A_i, m^2
  double margin = 0.0;  ///< [m] distance of the projected centre of mass (along gravity) to the nearest edge,
                        ///< negative outside
  int contacts = 0;     ///< distinct contact points that went in
};
/// From contacts collected over several steps (paper §3.2); contacts with a gap above `max_gap` are
/// dropped, points nearer than 1 mm merged. Projection of the centre of mass is along gravity (-z).
[[nodiscard]] SupportPolygon support_polygon(std::span<const Contact> contacts,
                                             const Eigen::Vector3d& p_W_com, double max_gap = 0.0005);

}  // namespace stonestack::physics

#pragma GCC visibility pop
