#pragma once
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::kinematics {

/// Columns are joints; rows 0..2 velocity of the flange's origin (m/rad), rows 3..5 angular velocity, both
/// in R.
using Jacobian = Eigen::Matrix<double, 6, 6>;

/// Geometric Jacobian of the flange.
[[nodiscard]] Jacobian jacobian(const RobotModel& robot, const Joints& q);

/// sqrt(det(J J^T)) with J = jacobian(robot, q): zero at a singularity.
[[nodiscard]] double manipulability(const RobotModel& robot, const Joints& q);

}  // namespace stonestack::kinematics
