#include "stonestack/kinematics/robot_model.hpp"

#include <algorithm>
#include <cmath>

#include "stonestack/core/error.hpp"

namespace stonestack::kinematics {

std::string malformed(const JointTrajectory& trajectory) {
  const std::size_t knots = trajectory.time.size();
  if (knots == 0 || trajectory.q.size() != knots || trajectory.qd.size() != knots)
    return concat("a trajectory needs as many times as positions and velocities, got ", knots, ", ",
                  trajectory.q.size(), ", ", trajectory.qd.size());
  for (std::size_t k = 0; k < knots; ++k) {
    if (!std::isfinite(trajectory.time[k]) || !trajectory.q[k].allFinite() || !trajectory.qd[k].allFinite())
      return concat("knot ", k, " of the trajectory is not finite");
    if (k == 0 ? trajectory.time[k] != 0 : trajectory.time[k] <= trajectory.time[k - 1])
      return concat("times must start at 0 and rise, knot ", k, " is at ", trajectory.time[k], " s");
  }
  return {};
}

JointState sample(const JointTrajectory& trajectory, double t) {
  require(!trajectory.time.empty(), "cannot sample an empty trajectory");
  require(trajectory.q.size() == trajectory.time.size() && trajectory.qd.size() == trajectory.time.size(),
          "a trajectory needs as many positions and velocities as times, got ", trajectory.time.size(),
          " times, ", trajectory.q.size(), " positions, ", trajectory.qd.size(), " velocities");
  const auto after = std::upper_bound(trajectory.time.begin(), trajectory.time.end(), t);
  if (after == trajectory.time.begin()) return {trajectory.q.front(), trajectory.qd.front()};
  if (after == trajectory.time.end()) return {trajectory.q.back(), trajectory.qd.back()};
  const auto i = static_cast<std::size_t>(after - trajectory.time.begin()) - 1;
  const double h = trajectory.time[i + 1] - trajectory.time[i];
  const double s = (t - trajectory.time[i]) / h;
  const Joints &q0 = trajectory.q[i], &q1 = trajectory.q[i + 1];
  const Joints &v0 = trajectory.qd[i], &v1 = trajectory.qd[i + 1];
  const double s2 = s * s;
  const double s3 = s2 * s;
  JointState state;
  state.q =
      (2 * s3 - 3 * s2 + 1) * q0 + (s3 - 2 * s2 + s) * h * v0 + (3 * s2 - 2 * s3) * q1 + (s3 - s2) * h * v1;
  state.qd = (6 * s2 - 6 * s) / h * (q0 - q1) + (3 * s2 - 4 * s + 1) * v0 + (3 * s2 - 2 * s) * v1;
  return state;
}

}  // namespace stonestack::kinematics
