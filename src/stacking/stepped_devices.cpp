#include "stacking/stepped_devices.hpp"

#include <cmath>
#include <cstdio>

#include "kinematics/fastest_tool.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

std::string millimetres(double metres) {
  return concat(std::lround(1e3 * metres), " mm");
}

}  // namespace

std::string to_text(const PlannedStep& step) {
  if (step.seconds <= 0) return step.name;
  char text[64];
  std::snprintf(text, sizeof text, ": %.1f s, tool up to %.3f m/s", step.seconds, step.tool_speed);
  return step.name + text;
}

SteppedDevices::SteppedDevices(const Cell& cell, const RobotModel& robot, const BeforeMotion& ask,
                               const Journal* journal)
    : inner_(cell),
      asking_{robot, cell.layout.T_F_T, ask, journal},
      arm_(cell.arm, asking_),
      gripper_(cell.gripper, asking_) {}

Cell SteppedDevices::cell() {
  return {arm_, gripper_, inner_.force_torque, inner_.camera, inner_.clock, inner_.layout};
}

void SteppedDevices::Asking::about(const std::string& name) const {
  if (!ask({name})) throw Interrupted();
}

void SteppedDevices::Asking::about(const JointTrajectory& trajectory) const {
  const std::string step = journal == nullptr ? "" : journal->step();
  if (!ask({step.empty() ? "move the arm" : step, trajectory.duration(),
            fastest_tool(trajectory, robot, T_F_T)}))
    throw Interrupted();
}

MotionResult SteppedDevices::SteppedArm::follow(const JointTrajectory& trajectory) {
  asking_.about(trajectory);
  return arm_.follow(trajectory);
}

MotionResult SteppedDevices::SteppedArm::carry(const JointTrajectory& trajectory) {
  asking_.about(trajectory);
  return arm_.carry(trajectory);
}

MotionResult SteppedDevices::SteppedArm::follow_guarded(const GuardedMotion& motion) {
  asking_.about(motion.trajectory);
  return arm_.follow_guarded(motion);
}

GripperState SteppedDevices::SteppedGripper::move(double opening, double speed, double force) {
  const bool closes = opening < gripper_.state().opening;
  if (closes && opening <= 0)
    asking_.about(concat("close the fingers on the stone, with ", force, " N"));
  else
    asking_.about(concat(closes ? "close" : "open", " the fingers to ", millimetres(opening)));
  return gripper_.move(opening, speed, force);
}

void SteppedDevices::SteppedGripper::spread(double spacing) {
  asking_.about("bring fingers B and C to a distance of " + millimetres(spacing));
  gripper_.spread(spacing);
}

}  // namespace stonestack::stacking
