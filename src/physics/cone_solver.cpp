#include "physics/cone_solver.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack {
namespace {

constexpr double kCalm = 1e-9;     // m/s: smaller changes end the iteration
constexpr double kSlop = 2e-5;     // m: depth that is left alone, so that resting touches do not flicker
constexpr double kRecovery = 0.2;  // share of a depth beyond kSlop that one step takes away
constexpr double kFastest = 0.5;   // m/s: at most, while positions are corrected

}  // namespace

btScalar ConeSolver::solveGroup(btCollisionObject** bodies, int body_count, btPersistentManifold**, int,
                                btTypedConstraint**, int, const btContactSolverInfo& info, btIDebugDraw*,
                                btDispatcher*) {
  if (body_count == 0) return 0.0;  // Bullet asks once more for what its islands left over: nothing
  gather_bodies(bodies, body_count, info.m_timeStep);
  gather_rows();
  const double scale = last_dt_ > 0.0 ? info.m_timeStep / last_dt_ : 1.0;
  last_dt_ = info.m_timeStep;
  for (Row& row : rows_)
    for (double& impulse : row.impulse) impulse *= scale;
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
    body.v = to_eigen(rigid->getLinearVelocity());
    body.w = to_eigen(rigid->getAngularVelocity());
    body.push_v.setZero();
    body.push_w.setZero();
    body.inverse_inertia.setZero();
    if (!rigid->isStaticOrKinematicObject()) {
      body.inverse_mass = rigid->getInvMass();
      body.inverse_inertia = to_eigen(rigid->getInvInertiaTensorWorld());
      body.v += dt * body.inverse_mass * to_eigen(rigid->getTotalForce());
      body.w += dt * (body.inverse_inertia * to_eigen(rigid->getTotalTorque()));
      body.w += to_eigen(rigid->computeGyroscopicImpulseImplicit_Body(dt));
    }
    bodies_.push_back(body);
  }
}

ConeSolver::Row ConeSolver::make_row(int a, int b, Touch& touch, double friction) const {
  Row row;
  row.a = a;
  row.b = b;
  row.touch = &touch;
  row.friction = friction;
  row.axis[0] = touch.n_W;
  row.axis[1] = touch.n_W.unitOrthogonal();
  row.axis[2] = touch.n_W.cross(row.axis[1]);
  const Body& A = bodies_[static_cast<std::size_t>(a)];
  const Body& B = bodies_[static_cast<std::size_t>(b)];
  const Vector r_a = touch.p_W + touch.gap * touch.n_W - to_eigen(A.rigid->getCenterOfMassPosition());
  const Vector r_b = touch.p_W - to_eigen(B.rigid->getCenterOfMassPosition());
  for (int i = 0; i < 3; ++i) {
    row.turn_a[i] = r_a.cross(row.axis[i]);
    row.turn_b[i] = r_b.cross(row.axis[i]);
    row.inertia_a[i] = A.inverse_inertia * row.turn_a[i];
    row.inertia_b[i] = B.inverse_inertia * row.turn_b[i];
    row.mass[i] = 1.0 / (A.inverse_mass + B.inverse_mass + row.turn_a[i].dot(row.inertia_a[i]) +
                         row.turn_b[i].dot(row.inertia_b[i]));
  }
  // One effective mass for both tangents, else friction would not oppose the sliding: the smallest along any.
  const auto response = [&](int i, int j) {
    return row.turn_a[i].dot(row.inertia_a[j]) + row.turn_b[i].dot(row.inertia_b[j]);
  };
  const double mean = 0.5 * (1.0 / row.mass[1] + 1.0 / row.mass[2]);
  const double half = 0.5 * (1.0 / row.mass[1] - 1.0 / row.mass[2]);
  const double skew = response(1, 2);
  row.mass[1] = row.mass[2] = 1.0 / (mean + std::sqrt(half * half + skew * skew));
  row.impulse[0] = touch.impulse;
  row.impulse[1] = touch.friction.dot(row.axis[1]);
  row.impulse[2] = touch.friction.dot(row.axis[2]);
  return row;
}

void ConeSolver::gather_rows() {
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
    for (Touch& touch : algorithm->touches())
      rows_.push_back(make_row(algorithm->a()->getCompanionId(), algorithm->b()->getCompanionId(), touch,
                               algorithm->friction()));
}

double ConeSolver::speed(const Row& row, int axis) const {
  const Body& A = bodies_[static_cast<std::size_t>(row.a)];
  const Body& B = bodies_[static_cast<std::size_t>(row.b)];
  return row.axis[axis].dot(A.v - B.v) + row.turn_a[axis].dot(A.w) - row.turn_b[axis].dot(B.w);
}

void ConeSolver::push(const Row& row, int axis, double impulse) {
  Body& A = bodies_[static_cast<std::size_t>(row.a)];
  Body& B = bodies_[static_cast<std::size_t>(row.b)];
  A.v += (impulse * A.inverse_mass) * row.axis[axis];
  A.w += impulse * row.inertia_a[axis];
  B.v -= (impulse * B.inverse_mass) * row.axis[axis];
  B.w -= impulse * row.inertia_b[axis];
}

/// One turn over a touch; returns the largest change of a relative speed, m/s.
double ConeSolver::solve_row(Row& row, double dt) {
  const double allowed = std::max(row.touch->gap, 0.0) / dt;
  const double before = row.impulse[0];
  row.impulse[0] = std::max(0.0, before - row.mass[0] * (speed(row, 0) + allowed));
  double change = std::abs(row.impulse[0] - before) / row.mass[0];
  if (row.impulse[0] != before) push(row, 0, row.impulse[0] - before);

  const double old1 = row.impulse[1], old2 = row.impulse[2];
  double f1 = old1 - row.mass[1] * speed(row, 1);
  double f2 = old2 - row.mass[2] * speed(row, 2);
  const double limit = row.friction * row.impulse[0],
               length = std::sqrt(f1 * f1 + f2 * f2);  // std::hypot took 4 % of a run
  if (length > limit) {
    f1 *= limit / length;
    f2 *= limit / length;
  }
  row.impulse[1] = f1;
  row.impulse[2] = f2;
  if (f1 != old1) push(row, 1, f1 - old1);
  if (f2 != old2) push(row, 2, f2 - old2);
  change = std::max(change, std::abs(f1 - old1) / row.mass[1]);
  return std::max(change, std::abs(f2 - old2) / row.mass[2]);
}

void ConeSolver::solve_velocities(int iterations, double dt) {
  for (const Row& row : rows_)
    for (int i = 0; i < 3; ++i) push(row, i, row.impulse[i]);
  for (iterations_ = 0; iterations_ < iterations;) {
    double change = 0.0;
    for (Row& row : rows_) change = std::max(change, solve_row(row, dt));
    ++iterations_;
    if (change < kCalm) break;
  }
  for (Row& row : rows_) {
    row.touch->impulse = row.impulse[0];
    row.touch->friction = row.impulse[1] * row.axis[1] + row.impulse[2] * row.axis[2];
  }
}

void ConeSolver::solve_positions(int iterations, double dt) {
  const bool needed =
      std::any_of(rows_.begin(), rows_.end(), [](const Row& r) { return r.touch->gap < -kSlop; });
  if (!needed) return;
  for (int i = 0; i < iterations; ++i) {
    double change = 0.0;
    for (Row& row : rows_) {
      Body& A = bodies_[static_cast<std::size_t>(row.a)];
      Body& B = bodies_[static_cast<std::size_t>(row.b)];
      const double depth = -row.touch->gap - kSlop;
      const double wanted = depth > 0.0 ? std::min(kRecovery * depth / dt, kFastest) : depth / dt;
      const double now =
          row.axis[0].dot(A.push_v - B.push_v) + row.turn_a[0].dot(A.push_w) - row.turn_b[0].dot(B.push_w);
      const double before = row.push;
      row.push = std::max(0.0, before - row.mass[0] * (now - wanted));
      const double impulse = row.push - before;
      A.push_v += (impulse * A.inverse_mass) * row.axis[0];
      A.push_w += impulse * row.inertia_a[0];
      B.push_v -= (impulse * B.inverse_mass) * row.axis[0];
      B.push_w -= impulse * row.inertia_b[0];
      change = std::max(change, std::abs(impulse) / row.mass[0]);
    }
    if (change < 1e-3 * kRecovery * kSlop / dt) break;
  }
}

void ConeSolver::write_back(double dt) {
  for (Body& body : bodies_) {
    if (body.rigid->isStaticOrKinematicObject()) continue;
    body.rigid->setLinearVelocity(to_bullet(body.v));
    body.rigid->setAngularVelocity(to_bullet(body.w));
    if (body.push_v.isZero(0.0) && body.push_w.isZero(0.0)) continue;
    btTransform moved;
    btTransformUtil::integrateTransform(body.rigid->getWorldTransform(), to_bullet(body.push_v),
                                        to_bullet(body.push_w), dt, moved);
    body.rigid->setCenterOfMassTransform(moved);
  }
}

}  // namespace stonestack
