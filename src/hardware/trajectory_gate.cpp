#include "hardware/trajectory_gate.hpp"

#include <cmath>

#include "hardware/constants.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

constexpr double kLimitSlack = 1e-6;      // rad, of rounding
constexpr double kWorkspaceSlack = 1e-4;  // m
constexpr double kHarder = 1.01;          // times the joint acceleration limit, of rounding

std::string find_bad_step(const JointState& before, const JointState& now, double t, double dt,
                          const RobotModel& robot, double margin) {
  for (int j = 0; j < 6; ++j) {
    if (now.q[j] > robot.upper[j] + kLimitSlack || now.q[j] < robot.lower[j] - kLimitSlack)
      return concat("joint ", j + 1, " at ", now.q[j], " rad, limits ", robot.lower[j], " to ",
                    robot.upper[j], " rad, at ", t, " s");
    const double speed = std::abs(now.q[j] - before.q[j]) / dt;
    if (speed > margin * robot.velocity[j])
      return concat("joint ", j + 1, " at ", speed, " rad/s, limit ", robot.velocity[j], " rad/s, at ", t,
                    " s");
    const double change = std::abs(now.qd[j] - before.qd[j]) / dt;
    if (change > kHarder * robot.acceleration[j])
      return concat("joint ", j + 1, " changes its speed by ", change, " rad/s^2, limit ",
                    robot.acceleration[j], " rad/s^2, at ", t, " s");
  }
  if (auto outside = describe_outside_workspace(robot, now.q, kWorkspaceSlack); !outside.empty())
    return concat(outside, ", at ", t, " s");
  if (auto outside = describe_outside_fence(robot, now.q, kWorkspaceSlack); !outside.empty())
    return concat(outside, ", at ", t, " s");
  return {};
}

Eigen::Vector3d tool_tip(const RobotModel& robot, const Joints& q, const TrajectoryGate& gate) {
  return (gate.T_W_R * forward(robot, q) * gate.T_F_T).translation();
}

/// `before` and `now`: the tool's tip in W, one control step apart.
std::string find_fast_tool(const Eigen::Vector3d& before, const Eigen::Vector3d& now, double t, double dt,
                           const RobotModel& robot) {
  const double speed = (now - before).norm() / dt;
  if (!(speed > kSpeedMargin * robot.tool_speed)) return {};
  return concat("the tool at (", now.x(), ", ", now.y(), ", ", now.z(), ") m moves at ", speed,
                " m/s, limit ", robot.tool_speed, " m/s, at ", t,
                " s; plan it slower, or allow more by limits.tool_speed in the cell file");
}

}  // namespace

std::string find_path_fault(const JointTrajectory& trajectory, const Joints& q, const RobotModel& robot,
                            const TrajectoryGate& gate) {
  if (auto fault = malformed(trajectory); !fault.empty()) return fault;
  const double gap = (trajectory.q.front() - q).cwiseAbs().maxCoeff();
  if (!(gap <= kStartTolerance))
    return concat("the trajectory starts ", gap, " rad from where the arm is (allowed ", kStartTolerance,
                  ")");
  const double dt = gate.period;
  JointState before{trajectory.q.front(), Joints::Zero()};  // at rest, and after the last step again
  Eigen::Vector3d p_W_before = tool_tip(robot, before.q, gate);
  const auto steps = static_cast<long>(std::ceil(trajectory.duration() / dt));
  for (long i = 0; i <= steps + 1; ++i) {
    const double t = static_cast<double>(i) * dt;
    JointState now = sample(trajectory, t);
    if (i > steps) now.qd.setZero();
    auto fault = find_bad_step(before, now, t, dt, robot, kSpeedMargin);
    const Eigen::Vector3d p_W = tool_tip(robot, now.q, gate);
    if (fault.empty()) fault = find_fast_tool(p_W_before, p_W, t, dt, robot);
    if (!fault.empty()) return fault;
    before = now;
    p_W_before = p_W;
  }
  return {};
}

}  // namespace stonestack::hardware
