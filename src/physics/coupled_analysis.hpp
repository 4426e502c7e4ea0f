#pragma once
#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "stonestack/physics/equilibrium.hpp"

namespace stonestack::physics {

/// A contact of an assembly with the share of the contact area that it stands for.
struct BlockContact {
  Contact contact;         ///< `below` and `above` index the bodies; kTable: a support
  double stiffness = 1.0;  ///< area that the point stands for, in any unit common to all contacts
};

/// State of an assembly under a load.
struct CoupledState {
  bool stands = false;      ///< forces and motions were found that agree
  double unbalanced = 0.0;  ///< largest force that stays unbalanced on a body, as a share of its weight
  int moving = -1;          ///< body with the largest unbalanced force; -1 where it stands
  Eigen::VectorXd motion;   ///< six a body: translation, rotation vector times `length`; scale is arbitrary
  std::vector<Eigen::Vector3d> forces_W;  ///< of each contact, on `above`, in shares of the total weight
};

/// Result of `analyse_coupled`.
struct CoupledAnalysis {
  CoupledState rest;                                    ///< under its own weight
  double margin = 0.0;                                  ///< [g] as in Equilibrium
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();  ///< W, unit: weakest direction
  double min_friction = 0.0;                            ///< smallest that stands; infinity if none up to 2
  int weakest_contact = -1;                             ///< next to give way in the weakest direction
};

/// Coupled rigid-block analysis (Kao et al., Computer-Aided Design 146, 2022): forces *and* motions. Contact
/// forces count only if a small motion of the blocks produces them: a contact presses where its bodies
/// approach each other and friction opposes sliding. Forces that merely balance each other, such as the
/// thrust with which two walls would have to squeeze a block between them, are therefore refused, while a
/// force method accepts them.
///
/// Contacts are regularised by a penalty (normal force k max(0, approach), Coulomb friction with a tangential
/// spring of the same stiffness, deformation theory), which makes the problem positively homogeneous: the
/// verdict does not depend on k. Friction is not associated, that is, sliding does not open the joint; with
/// an associated law the problem would be a convex cone programme, but sliding would create thrust and hold
/// the shelf that only friction carries. The non-smooth equations are solved by the semismooth Newton method
/// with a proximal term (implicit viscous creep) whose weight goes to zero: a stable assembly comes to rest,
/// an unstable one keeps an unbalanced force. A problem that is not solved counts as an assembly that falls.
class CoupledSolver {
 public:
  CoupledSolver(std::span<const StaticBody> bodies, std::span<const BlockContact> contacts);
  ~CoupledSolver();
  CoupledSolver(const CoupledSolver&) = delete;
  CoupledSolver& operator=(const CoupledSolver&) = delete;
  /// `load_g`: acceleration of every body in g, (0, 0, -1) for rest. `start` is a state to begin from, or
  /// null.
  [[nodiscard]] CoupledState solve(double friction, const Eigen::Vector3d& load_g,
                                   const CoupledState* start = nullptr);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Verdict, margin over `directions` horizontal directions, and smallest friction (both by bisection).
/// `down` is the direction of gravity. @throws InvalidArgument as `solve_equilibrium`.
[[nodiscard]] CoupledAnalysis analyse_coupled(std::span<const StaticBody> bodies,
                                              std::span<const BlockContact> contacts, double friction,
                                              int directions,
                                              const Eigen::Vector3d& down = -Eigen::Vector3d::UnitZ());

}  // namespace stonestack::physics
