#include "stacking/recorded_devices.hpp"

#include <algorithm>

namespace stonestack::stacking {
namespace {

constexpr double kInterval = 0.1;  // s between samples of a motion: at 1 rad/s a joint turns by 0.1 rad

}  // namespace

RecordedDevices::RecordedDevices(const Cell& cell, Timeline& timeline)
    : inner_(cell),
      recording_{cell.clock, timeline, {}},
      arm_(cell.arm, recording_),
      gripper_(cell.gripper, recording_),
      force_torque_(cell.force_torque, recording_) {}

Cell RecordedDevices::cell() {
  return {arm_, gripper_, force_torque_, inner_.camera, inner_.clock, inner_.layout};
}

void RecordedDevices::Recording::add(double time) {
  if (!timeline.samples.empty() && time < timeline.samples.back().time) return;
  now.time = time;
  timeline.samples.push_back(now);
}

void RecordedDevices::Recording::add_motion(const JointTrajectory& trajectory, double begin,
                                            const MotionResult& result) {
  const double end = clock.now();
  const double followed = std::min(trajectory.duration(), end - begin);
  if (!trajectory.time.empty())
    for (double t = 0.0; t < followed; t += kInterval) {
      now.q = sample(trajectory, t).q;
      add(begin + t);
    }
  now.q = result.q;
  now.force = result.force;
  add(end);
}

ArmState RecordedDevices::RecordedArm::state() {
  ArmState state = arm_.state();
  if (recording_.timeline.samples.empty()) {  // where the arm stands when the run begins
    recording_.now.q = state.q;
    recording_.add(recording_.clock.now());
  }
  return state;
}

MotionResult RecordedDevices::RecordedArm::follow(const JointTrajectory& trajectory) {
  const double begin = recording_.clock.now();
  MotionResult result = arm_.follow(trajectory);
  recording_.add_motion(trajectory, begin, result);
  return result;
}

MotionResult RecordedDevices::RecordedArm::follow_guarded(const GuardedMotion& motion) {
  const double begin = recording_.clock.now();
  MotionResult result = arm_.follow_guarded(motion);
  recording_.add_motion(motion.trajectory, begin, result);
  return result;
}

void RecordedDevices::RecordedArm::set_payload(double mass, const Eigen::Vector3d& p_F_com) {
  arm_.set_payload(mass, p_F_com);
}

GripperState RecordedDevices::RecordedGripper::move(double opening, double speed, double force) {
  recording_.add(recording_.clock.now());
  GripperState state = gripper_.move(opening, speed, force);
  recording_.now.opening = state.opening;
  recording_.now.holds = state.object;
  recording_.add(recording_.clock.now());
  return state;
}

void RecordedDevices::RecordedGripper::spread(double spacing) {
  gripper_.spread(spacing);
  recording_.now.spacing = spacing;
  recording_.add(recording_.clock.now());
}

Wrench RecordedDevices::RecordedSensor::read() {
  Wrench wrench = sensor_.read();
  recording_.now.force = wrench.force.norm();
  recording_.add(recording_.clock.now());
  return wrench;
}

}  // namespace stonestack::stacking
