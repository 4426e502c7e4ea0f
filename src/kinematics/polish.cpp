#include "kinematics/polish.hpp"

#include <Eigen/Cholesky>
#include <limits>

#include "kinematics/jacobian_of.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::kinematics {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
constexpr int kSteps = 30;
constexpr double kLongest = 0.5;    // rad, of a step
constexpr int kPatience = 5;        // steps that bring nothing
constexpr int kEarly = 6;           // steps after which it is
constexpr double kFarEarly = 0.01;  // no further away, or it leads nowhere

/// Rotation vector of R. For a turn below a right angle its sine does, which is cheaper and as good a step.
Eigen::Vector3d turn_of(const Eigen::Matrix3d& R) {
  if (R.trace() > 1.5) return 0.5 * Eigen::Vector3d(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

}  // namespace

bool polish(const RobotModel& robot, const Pose& T_R_F, double tolerance, Joints& q) {
  // Beside a singularity a step may lead away again: the best angles are kept, not the last.
  Joints best = q;
  double min = std::numeric_limits<double>::infinity();
  for (int step = 0, gained = 0; step < kSteps && step - gained <= kPatience; ++step) {
    const std::array<Pose, 7> links = link_poses(robot, q);
    const Pose T = links[6] * robot.T_6_F;
    Vector6 error;
    error << T_R_F.translation() - T.translation(), turn_of(T_R_F.linear() * T.linear().transpose());
    const double rest = error.norm();
    if (rest < 0.9 * min) gained = step;
    if (rest < min) {
      min = rest;
      best = q;
    }
    if (rest < 1e-12 || (step >= kEarly && min > kFarEarly)) break;
    const Jacobian J = jacobian_of(links, T.translation());
    const Eigen::Matrix<double, 6, 6> normal =
        J * J.transpose() + rest * rest * Eigen::Matrix<double, 6, 6>::Identity();
    Joints move = J.transpose() * normal.ldlt().solve(error);
    if (!move.allFinite()) break;
    if (const double far = move.norm(); far > kLongest) move *= kLongest / far;
    q += move;
  }
  q = best;
  return min <= tolerance;
}

}  // namespace stonestack::kinematics
