#pragma once
#include <span>
#include <vector>

#include "stonestack/physics/contact.hpp"

namespace stonestack {

/// A rigid body for statics.
struct StaticBody {
  double mass = 0.0;                                  ///< kg
  Eigen::Vector3d p_W_com = Eigen::Vector3d::Zero();  ///< m
};

/// Verdict on a stack of rigid bodies with Coulomb contacts.
struct Equilibrium {
  bool stands = false;
  double margin =
      0.0;  ///< g: largest horizontal acceleration borne in the worst of the tested directions; 0 if it falls
  double least_friction =
      0;  ///< smallest friction coefficient at which it stands (bisection); infinity if none up to 2
  int weakest_contact =
      -1;  ///< index of the contact whose friction or normal bound is reached first; -1: none
};

/// Options of `solve_equilibrium`.
struct EquilibriumOptions {
  double friction = 0.1;
  int cone_edges = 8;        ///< generators of the inner friction cone
  int directions = 8;        ///< horizontal directions for the margin
  double torque_arm = 0.05;  ///< m, scales torques against forces
};

/// Contact forces in friction cones that balance gravity: a linear programme (Clp). `contacts` index into
/// `bodies` (kTable: the ground). Upper bound of what a stack bears (facts/physics.md §3): ask for a margin,
/// not for feasibility.
[[nodiscard]] Equilibrium solve_equilibrium(std::span<const StaticBody> bodies,
                                            std::span<const Contact> contacts,
                                            const EquilibriumOptions& options = {});

}  // namespace stonestack
