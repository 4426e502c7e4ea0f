#include "physics/cone_solver.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack::physics {
namespace {

constexpr double kCalm = 1e-8;     // m/s: smaller changes end the iteration
constexpr double kSlop = 2e-5;     // m: depth that is left alone, so that resting touches do not flicker
constexpr double kRecovery = 0.2;  // share of a depth beyond kSlop that one step takes away
constexpr double kFastest = 0.5;   // m/s: at most, while positions are corrected

}  // namespace

btScalar ConeSolver::solveGroup(btCollisionObject** bodies, int body_count, btPersistentManifold**, int,
                                btTypedConstraint**, int, const btContactSolverInfo& info, btIDebugDraw*,
                                btDispatcher*) {
  if (body_count == 0) return 0.0;  // Bullet asks once more for what its islands left over: nothing
  gather_bodies(bodies, body_count, info.m_timeStep);
  gather_rows(info.m_timeStep);
  const double scale = last_dt_ > 0.0 ? info.m_timeStep / last_dt_ : 1.0;
  last_dt_ = info.m_timeStep;
  for (Row& row : rows_)
    for (Axis& axis : row.axis) axis.impulse *= scale;
  solve_velocities(info.m_numIterations, info.m_timeStep);
  solve_positions(info.m_numIterations, info.m_timeStep);
  write_back(info.m_timeStep);
  return 0.0;
}

void ConeSolver::gather_bodies(btCollisionObject** bodies, int count, double dt) {
  bodies_.clear();
  for (int i = 0; i < count; ++i) {
    btRigidBody* rigid = btRigidBody::upcast(bodies[i]);
    rigid->setCompanionId(i);
    Body body;
    body.rigid = rigid;
    Vector v = to_eigen(rigid->getLinearVelocity()), w = to_eigen(rigid->getAngularVelocity());
    body.push.setZero();
    body.inverse_inertia.setZero();
    if (!rigid->isStaticOrKinematicObject()) {
      body.inverse_mass = rigid->getInvMass();
      body.inverse_inertia = to_eigen(rigid->getInvInertiaTensorWorld());
      v += dt * body.inverse_mass * to_eigen(rigid->getTotalForce());
      w += dt * (body.inverse_inertia * to_eigen(rigid->getTotalTorque()));
      w += to_eigen(rigid->computeGyroscopicImpulseImplicit_Body(dt));
    }
    body.velocity << v, w;
    bodies_.push_back(body);
  }
}

ConeSolver::Row ConeSolver::make_row(int a, int b, Touch& touch, double friction) const {
  Row row;
  row.a = a;
  row.b = b;
  row.touch = &touch;
  row.friction = friction;
  row.direction[0] = touch.n_W;
  row.direction[1] = touch.n_W.unitOrthogonal();
  row.direction[2] = touch.n_W.cross(row.direction[1]);
  const Body& A = bodies_[static_cast<std::size_t>(a)];
  const Body& B = bodies_[static_cast<std::size_t>(b)];
  const Vector r_a = touch.p_W + touch.gap * touch.n_W - to_eigen(A.rigid->getCenterOfMassPosition());
  const Vector r_b = touch.p_W - to_eigen(B.rigid->getCenterOfMassPosition());
  for (int i = 0; i < 3; ++i) {
    Axis& axis = row.axis[i];
    const Vector& n = row.direction[i];
    axis.of_a << n, r_a.cross(n);
    axis.of_b << -n, -r_b.cross(n);
    axis.change_a << A.inverse_mass * n, A.inverse_inertia * axis.of_a.tail<3>();
    axis.change_b << -B.inverse_mass * n, B.inverse_inertia * axis.of_b.tail<3>();
    axis.mass = 1.0 / (axis.of_a.dot(axis.change_a) + axis.of_b.dot(axis.change_b));
  }
  // One effective mass for both tangents, else friction would not oppose the sliding: the smallest along any.
  Axis &first = row.axis[1], &second = row.axis[2];
  const double mean = 0.5 * (1.0 / first.mass + 1.0 / second.mass);
  const double half = 0.5 * (1.0 / first.mass - 1.0 / second.mass);
  const double skew = first.of_a.dot(second.change_a) + first.of_b.dot(second.change_b);
  first.mass = second.mass = 1.0 / (mean + std::sqrt(half * half + skew * skew));
  row.axis[0].impulse = touch.impulse;
  for (int i = 1; i < 3; ++i) row.axis[i].impulse = touch.friction.dot(row.direction[i]);
  return row;
}

void ConeSolver::gather_rows(double dt) {
  rows_.clear();
  btBroadphasePairArray& pairs = broadphase_->getOverlappingPairCache()->getOverlappingPairArray();
  std::vector<TouchAlgorithm*> algorithms;
  for (int i = 0; i < pairs.size(); ++i)
    if (pairs[i].m_algorithm) algorithms.push_back(static_cast<TouchAlgorithm*>(pairs[i].m_algorithm));
  // The order of the rows must not depend on the broadphase's hash.
  std::sort(algorithms.begin(), algorithms.end(), [](const TouchAlgorithm* x, const TouchAlgorithm* y) {
    return std::pair(x->b()->getUserIndex(), x->a()->getUserIndex()) <
           std::pair(y->b()->getUserIndex(), y->a()->getUserIndex());
  });
  for (TouchAlgorithm* algorithm : algorithms)
    for (Touch& touch : algorithm->touches()) {
      rows_.push_back(make_row(algorithm->a()->getCompanionId(), algorithm->b()->getCompanionId(), touch,
                               algorithm->friction()));
      if (const double k = algorithm->stiffness(); k > 0.0) rows_.back().softness = 1.0 / (k * dt * dt);
    }
}

double ConeSolver::speed(const Row& row, int axis) const {
  const Body& A = bodies_[static_cast<std::size_t>(row.a)];
  const Body& B = bodies_[static_cast<std::size_t>(row.b)];
  return row.axis[axis].of_a.dot(A.velocity) + row.axis[axis].of_b.dot(B.velocity);
}

void ConeSolver::apply(const Row& row, int axis, double impulse) {
  bodies_[static_cast<std::size_t>(row.a)].velocity += impulse * row.axis[axis].change_a;
  bodies_[static_cast<std::size_t>(row.b)].velocity += impulse * row.axis[axis].change_b;
}

/// One iteration over a touch; returns the largest change of a relative speed, m/s.
double ConeSolver::solve_row(Row& row, double dt) {
  Axis &normal = row.axis[0], &first = row.axis[1], &second = row.axis[2];
  const bool soft = row.softness > 0.0;
  const double allowed = (soft ? row.touch->gap : std::max(row.touch->gap, 0.0)) / dt;
  const double before = normal.impulse;
  const double mass = soft ? 1.0 / (1.0 / normal.mass + row.softness) : normal.mass;
  normal.impulse = std::max(0.0, before - mass * (speed(row, 0) + allowed + row.softness * before));
  double change = std::abs(normal.impulse - before) / normal.mass;
  if (normal.impulse != before) apply(row, 0, normal.impulse - before);

  const double old1 = first.impulse, old2 = second.impulse;
  const double limit = row.friction * normal.impulse;
  if (limit == 0.0 && old1 == 0.0 && old2 == 0.0) return change;  // it does not touch: most rows
  double f1 = old1 - first.mass * speed(row, 1);
  double f2 = old2 - second.mass * speed(row, 2);
  const double length = std::sqrt(f1 * f1 + f2 * f2);  // std::hypot took 4 % of a run
  if (length > limit) {
    f1 *= limit / length;
    f2 *= limit / length;
  }
  first.impulse = f1;
  second.impulse = f2;
  if (f1 != old1) apply(row, 1, f1 - old1);
  if (f2 != old2) apply(row, 2, f2 - old2);
  change = std::max(change, std::abs(f1 - old1) / first.mass);
  return std::max(change, std::abs(f2 - old2) / second.mass);
}

void ConeSolver::solve_velocities(int iterations, double dt) {
  for (const Row& row : rows_)
    for (int i = 0; i < 3; ++i) apply(row, i, row.axis[i].impulse);
  for (iterations_ = 0; iterations_ < iterations;) {
    double change = 0.0;
    for (Row& row : rows_) change = std::max(change, solve_row(row, dt));
    ++iterations_;
    if (change < kCalm) break;
  }
  for (Row& row : rows_) {
    row.touch->impulse = row.axis[0].impulse;
    row.touch->friction = row.axis[1].impulse * row.direction[1] + row.axis[2].impulse * row.direction[2];
  }
}

void ConeSolver::solve_positions(int iterations, double dt) {
  const bool needed = std::any_of(rows_.begin(), rows_.end(),
                                  [](const Row& r) { return r.softness == 0.0 && r.touch->gap < -kSlop; });
  if (!needed) return;
  for (int i = 0; i < iterations; ++i) {
    double change = 0.0;
    for (Row& row : rows_) {
      if (row.softness > 0.0) continue;
      Body& A = bodies_[static_cast<std::size_t>(row.a)];
      Body& B = bodies_[static_cast<std::size_t>(row.b)];
      const Axis& normal = row.axis[0];
      const double depth = -row.touch->gap - kSlop;
      const double wanted = depth > 0.0 ? std::min(kRecovery * depth / dt, kFastest) : depth / dt;
      const double now = normal.of_a.dot(A.push) + normal.of_b.dot(B.push);
      const double before = row.push;
      row.push = std::max(0.0, before - normal.mass * (now - wanted));
      const double impulse = row.push - before;
      if (impulse == 0.0) continue;
      A.push += impulse * normal.change_a;
      B.push += impulse * normal.change_b;
      change = std::max(change, std::abs(impulse) / normal.mass);
    }
    if (change < 1e-3 * kRecovery * kSlop / dt) break;
  }
}

void ConeSolver::write_back(double dt) {
  for (Body& body : bodies_) {
    if (body.rigid->isStaticOrKinematicObject()) continue;
    body.rigid->setLinearVelocity(to_bullet(Vector(body.velocity.head<3>())));
    body.rigid->setAngularVelocity(to_bullet(Vector(body.velocity.tail<3>())));
    if (body.push.isZero(0.0)) continue;
    btTransform moved;
    btTransformUtil::integrateTransform(body.rigid->getWorldTransform(),
                                        to_bullet(Vector(body.push.head<3>())),
                                        to_bullet(Vector(body.push.tail<3>())), dt, moved);
    body.rigid->setCenterOfMassTransform(moved);
  }
}

}  // namespace stonestack::physics
