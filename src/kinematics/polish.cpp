#include "kinematics/polish.hpp"

#include <Eigen/Cholesky>
#include <limits>

#include "stonestack/kinematics/forward.hpp"
#include "stonestack/kinematics/jacobian.hpp"

namespace stonestack {

bool polish(const RobotModel& robot, const Pose& T_R_F, double tolerance, Joints& q) {
  // Beside a singularity a step may lead away again: the best angles are kept, not the last.
  Joints best = q;
  double least = std::numeric_limits<double>::infinity();
  for (int step = 0; step < 20; ++step) {
    const Pose T = forward(robot, q);
    const Eigen::AngleAxisd turn(T_R_F.linear() * T.linear().transpose());
    Eigen::Matrix<double, 6, 1> error;
    error << T_R_F.translation() - T.translation(), turn.angle() * turn.axis();
    const double rest = error.norm();
    if (rest < least) {
      least = rest;
      best = q;
    }
    if (rest < 1e-12) break;
    const Jacobian J = jacobian(robot, q);
    const Eigen::Matrix<double, 6, 6> normal =
        J * J.transpose() + 1e-3 * rest * Eigen::Matrix<double, 6, 6>::Identity();
    const Joints move = J.transpose() * normal.ldlt().solve(error);
    if (!move.allFinite() || move.norm() > 1.0) break;
    q += move;
  }
  q = best;
  return least <= tolerance;
}

}  // namespace stonestack
