#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "stonestack/core/rooms.hpp"

#pragma GCC visibility push(default)

namespace stonestack::kinematics {

/// Six joint angles, rad, in the order base, shoulder, elbow, wrist 1, wrist 2, wrist 3.
using Joints = Eigen::Matrix<double, 6, 1>;

/// Way points, joined by straight lines in joint space.
using JointPath = std::vector<Joints>;

/// Joint angles over time: cubic Hermite pieces between knots, so position and velocity are continuous.
struct JointTrajectory {
  std::vector<double> time;  ///< strictly rising, first is 0 [s]
  std::vector<Joints> q;     ///< [rad]
  std::vector<Joints> qd;    ///< [rad/s]

  [[nodiscard]] double duration() const { return time.empty() ? 0.0 : time.back(); }
};

/// Why these numbers are no trajectory: lengths that differ, what is not finite, times that do not start at 0
/// and rise. Empty: they are one.
[[nodiscard]] std::string malformed(const JointTrajectory& trajectory);

struct JointState {
  Joints q = Joints::Zero();
  Joints qd = Joints::Zero();
};
/// State at `t`, clamped to the ends. Throws InvalidArgument for an empty trajectory.
[[nodiscard]] JointState sample(const JointTrajectory& trajectory, double t);

}  // namespace stonestack::kinematics

#pragma GCC visibility pop
