#include "physics/rigid_frame.hpp"

#include <Eigen/Eigenvalues>

namespace stonestack::physics {

Pose principal_frame(const MassProperties& mass, Eigen::Vector3d* moments) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(mass.I_M);
  *moments = solver.eigenvalues();
  Pose T_O_P = Pose::Identity();
  T_O_P.linear() = solver.eigenvectors();
  if (T_O_P.linear().determinant() < 0) T_O_P.linear().col(2) *= -1.0;
  T_O_P.translation() = mass.p_O_M;
  return T_O_P;
}

Twist velocity_between(const Pose& from, const Pose& to, double dt) {
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(to.linear() * from.linear().transpose()).normalized());
  const double angle = turn.angle() > M_PI ? turn.angle() - 2 * M_PI : turn.angle();
  return {(to.translation() - from.translation()) / dt, turn.axis() * (angle / dt)};
}

}  // namespace stonestack::physics
