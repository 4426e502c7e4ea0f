#pragma once
#include <vector>

#include "physics/bullet.hpp"
#include "physics/surface_shape.hpp"

namespace stonestack::physics {

/// Velocities and impulses of one step: projected Gauss-Seidel over touches with round friction cones
/// (Bullet's own solver limits the two friction directions each for itself, which is up to 41 % too much on
/// the diagonal), full warm start, and positions corrected apart from velocities so that pushing stones apart
/// adds no energy. A touch with a stiffness is a spring, implicit in time. Ends early once an iteration
/// changes velocities by less than `kCalm`.
class ConeSolver : public btConstraintSolver {
 public:
  explicit ConeSolver(btBroadphaseInterface* broadphase) : broadphase_(broadphase) {}

  btScalar solveGroup(btCollisionObject** bodies, int body_count, btPersistentManifold**, int,
                      btTypedConstraint**, int, const btContactSolverInfo& info, btIDebugDraw*,
                      btDispatcher*) override;
  void reset() override {}
  [[nodiscard]] btConstraintSolverType getSolverType() const override { return BT_SEQUENTIAL_IMPULSE_SOLVER; }

  /// Iterations of the last step.
  [[nodiscard]] int iterations() const { return iterations_; }

 private:
  using Vector = Eigen::Vector3d;
  using Vector6 = Eigen::Matrix<double, 6, 1>;  ///< linear, then angular
  struct Body {
    btRigidBody* rigid = nullptr;
    double inverse_mass = 0.0;
    Eigen::Matrix3d inverse_inertia;  ///< world axes
    Vector6 velocity;
    Vector6 push;  ///< correction of the position, as a velocity
  };
  /// Effect of a touch on its two bodies along one direction.
  struct Axis {
    Vector6 of_a, of_b;          ///< relative speed is of_a . velocity of A + of_b . velocity of B
    Vector6 change_a, change_b;  ///< of their velocities by an impulse of 1
    double mass = 0.0;           ///< effective
    double impulse = 0.0;
  };
  struct Row {
    int a, b;
    Touch* touch;
    double friction;
    Vector direction[3];  ///< normal, two tangents
    Axis axis[3];
    double push = 0.0;
    double softness = 0.0;  ///< by which an impulse of 1 gives way in a step, as a speed; 0: rigid
  };
  void gather_bodies(btCollisionObject** bodies, int count, double dt);
  void gather_rows(double dt);
  Row make_row(int a, int b, Touch& touch, double friction) const;
  [[nodiscard]] double speed(const Row& row, int axis) const;
  void apply(const Row& row, int axis, double impulse);
  double solve_row(Row& row, double dt);
  void solve_velocities(int iterations, double dt);
  void solve_positions(int iterations, double dt);
  void write_back(double dt);

  btBroadphaseInterface* broadphase_;
  std::vector<Body> bodies_;
  std::vector<Row> rows_;
  int iterations_ = 0;
  double last_dt_ = 0.0;  ///< of the step that the kept impulses are from [s]
};

}  // namespace stonestack::physics
