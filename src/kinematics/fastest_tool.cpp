#include "kinematics/fastest_tool.hpp"

#include <algorithm>

namespace stonestack::kinematics {

double fastest_tool(const JointTrajectory& trajectory, const RobotModel& robot, const Pose& T_F_T) {
  constexpr double kStep = 0.008;  // s
  if (trajectory.time.empty()) return 0.0;
  const auto tip = [&](double t) -> Eigen::Vector3d {
    return (forward(robot, sample(trajectory, t).q) * T_F_T).translation();
  };
  double fastest = 0.0;
  Eigen::Vector3d before = tip(0.0);
  for (double t = kStep; t < trajectory.duration() + kStep; t += kStep) {
    const Eigen::Vector3d now = tip(t);
    fastest = std::max(fastest, (now - before).norm() / kStep);
    before = now;
  }
  return fastest;
}

}  // namespace stonestack::kinematics
