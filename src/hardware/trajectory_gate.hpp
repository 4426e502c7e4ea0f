#pragma once
#include <string>

#include "stonestack/geometry/pose.hpp"
#include "stonestack/kinematics/robot_model.hpp"

/// Private to drivers and simulated devices: the last gate before an arm moves.
namespace stonestack::hardware {

/// Base of the arm in W, tool tip in the flange, and the period of the control steps [s].
struct TrajectoryGate {
  Pose T_W_R = Pose::Identity();
  Pose T_F_T = Pose::Identity();
  double period = 0.008;
};

/// Empty if an arm that stands at `q` may follow the trajectory, else what is wrong with it: sizes, numbers
/// that are not finite, times that do not rise from 0, a start far from `q`, and, at every control step,
/// joint limits, speeds, accelerations, the tool's speed and workspace and the arm's fence.
[[nodiscard]] std::string find_path_fault(const JointTrajectory& trajectory, const Joints& q,
                                          const RobotModel& robot, const TrajectoryGate& gate);

}  // namespace stonestack::hardware
