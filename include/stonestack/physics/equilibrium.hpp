#pragma once
#include <span>
#include <vector>

#include "stonestack/physics/contact.hpp"

#pragma GCC visibility push(default)

namespace stonestack::physics {

/// A rigid body for statics.
struct StaticBody {
  double mass = 0.0;                                  ///< mass, kg
  Eigen::Vector3d p_W_com = Eigen::Vector3d::Zero();  ///< centre of mass, m
};

/// Verdict on a stack of rigid bodies with Coulomb contacts.
struct Equilibrium {
  bool stands = false;
  double margin =
      0.0;  ///< largest horizontal acceleration borne in the worst of the tested directions; 0 if it falls
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();  ///< W, unit: where that push goes
  double least_friction =
      0;  ///< smallest friction coefficient at which it stands (bisection); infinity if none up to 2
  /// Contact that gives way first in the worst direction: the one whose friction limits the margin most, or,
  /// where friction does not, the one that carries most as the stack tips over it. -1: none (it falls, or
  /// free bodies).
  int weakest_contact = -1;
};

/// Options of `solve_equilibrium`.
struct EquilibriumOptions {
  double friction = 0.1;
  int cone_edges = 8;          ///< generators of the inner friction cone
  int directions = 8;          ///< horizontal directions for the margin
  double torque_arm = 0.05;    ///< scale of torques against forces, m
  double tolerance = 1e-6;     ///< share of the total weight that may stay unbalanced
  bool least_friction = true;  ///< also find `least_friction` (a dozen more programmes)
};

/// Contact forces in friction cones that balance gravity: a linear programme (GLPK). `contacts` index into
/// `bodies` (kTable: the ground). Upper bound of what a stack bears (contacts may shift): ask for a margin,
/// not for feasibility. Contacts of one pair within 1 mm and 3 deg count once. A programme that the solver
/// cannot solve counts as a stack that falls. Throws InvalidArgument for indices out of range, masses that
/// are not positive, points that are not finite, and friction that is negative or not finite.
[[nodiscard]] Equilibrium solve_equilibrium(std::span<const StaticBody> bodies,
                                            std::span<const Contact> contacts,
                                            const EquilibriumOptions& options = {});

}  // namespace stonestack::physics

#pragma GCC visibility pop
