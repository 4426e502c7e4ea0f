#include "stacking/recorded_devices.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kInterval = 0.1;  // s between samples of a motion: at 1 rad/s a joint turns by 0.1 rad

constexpr double kMaxJoint = 2 * std::numbers::pi + 0.1;  // rad: no joint of such an arm turns further
constexpr double kMaxMoved = 0.05;    // rad beside the end of the last motion; drivers refuse 0.01 at a start
constexpr double kMaxForce = 2000.0;  // N: a wrist sensor's range is a few hundred
constexpr double kMaxDepth = 20.0;    // m: depth cameras of the arm see less
constexpr double kMinShown = 0.01;    // share of the pixels that have a depth

void check_joints(const Joints& q) {
  for (const double angle : q)
    if (!(std::abs(angle) <= kMaxJoint))
      throw DeviceError("arm", concat("reports a joint at ", angle, " rad"),
                        "check link and controller before anything moves");
}

GripperState checked(const GripperState& state) {
  if (!std::isfinite(state.opening))
    throw DeviceError("gripper", concat("reports an opening of ", state.opening, " m"), "check its driver");
  return state;
}

/// Motion that is reported as done and ends elsewhere: stopped by what nobody reports.
void check_end(const JointTrajectory& trajectory, MotionResult& result) {
  using Status = MotionResult::Status;
  if (trajectory.q.empty() || (result.status != Status::kDone && result.status != Status::kNoContact)) return;
  const double short_of = (result.q - trajectory.q.back()).cwiseAbs().maxCoeff();
  if (short_of <= kMaxMoved) return;
  result.status = Status::kStopped;
  result.reason = concat("reports a motion as done and stands ", short_of, " rad from its end");
}

void check_depths(const DepthImage& image) {
  std::size_t shown = 0, wild = 0;
  for (const float z : image.z) {
    if (z == 0.0F) continue;
    ++(z > 0.0F && z < kMaxDepth ? shown : wild);
  }
  if (wild > shown)
    throw DeviceError("camera", concat(wild, " depths of a frame are not finite or beyond ", kMaxDepth, " m"),
                      "check the unit of its depths");
  if (static_cast<double>(shown) < kMinShown * static_cast<double>(image.z.size()))
    throw DeviceError("camera", concat("a frame has only ", shown, " depths"),
                      "look at lens, light and distance");
}

}  // namespace

RecordedDevices::RecordedDevices(const Cell& cell, Timeline& timeline)
    : inner_(cell),
      recording_{cell.clock, timeline, {}},
      arm_(cell.arm, recording_),
      gripper_(cell.gripper, recording_),
      force_torque_(cell.force_torque, recording_),
      camera_(cell.camera) {}

Cell RecordedDevices::cell() {
  return {arm_, gripper_, force_torque_, camera_, inner_.clock, inner_.layout};
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
  check_joints(state.q);
  if (q_at_end_ && (state.q - *q_at_end_).cwiseAbs().maxCoeff() > kMaxMoved)
    throw DeviceError("arm",
                      concat("stands ", (state.q - *q_at_end_).cwiseAbs().maxCoeff(),
                             " rad from where its last motion ended, and no motion was commanded"),
                      "look at the cell, then start or resume the run");
  if (recording_.timeline.samples.empty()) {  // where the arm stands when the run begins
    recording_.now.q = state.q;
    recording_.add(recording_.clock.now());
  }
  return state;
}

MotionResult RecordedDevices::RecordedArm::end_motion(const JointTrajectory& trajectory, double begin,
                                                      MotionResult result) {
  check_joints(result.q);
  check_end(trajectory, result);
  if (result.status == MotionResult::Status::kLost) {  // it may go on by itself
    try {
      arm_.stop();
    } catch (const DeviceError& problem) {
      result.reason += concat("; the arm did not confirm a stop: ", problem.what());
    }
  }
  q_at_end_ = result.q;
  recording_.add_motion(trajectory, begin, result);
  return result;
}

MotionResult RecordedDevices::RecordedArm::follow(const JointTrajectory& trajectory) {
  const double begin = recording_.clock.now();
  return end_motion(trajectory, begin, arm_.follow(trajectory));
}

MotionResult RecordedDevices::RecordedArm::carry(const JointTrajectory& trajectory) {
  const double begin = recording_.clock.now();
  return end_motion(trajectory, begin, arm_.carry(trajectory));
}

MotionResult RecordedDevices::RecordedArm::follow_guarded(const GuardedMotion& motion) {
  const double begin = recording_.clock.now();
  return end_motion(motion.trajectory, begin, arm_.follow_guarded(motion));
}

void RecordedDevices::RecordedArm::set_payload(double mass, const Eigen::Vector3d& p_F_com) {
  arm_.set_payload(mass, p_F_com);
}

GripperState RecordedDevices::RecordedGripper::state() {
  return checked(gripper_.state());
}

GripperState RecordedDevices::RecordedGripper::move(double opening, double speed, double force) {
  recording_.add(recording_.clock.now());
  GripperState state = checked(gripper_.move(opening, speed, force));
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
  if (!(wrench.force.norm() <= kMaxForce) || !wrench.torque.allFinite())
    throw DeviceError("force sensor", concat("reports ", wrench.force.norm(), " N"),
                      "check its link and its mounting");
  recording_.now.force = wrench.force.norm();
  recording_.add(recording_.clock.now());
  return wrench;
}

DepthFrame RecordedDevices::CheckedCamera::capture() {
  DepthFrame frame = camera_.capture();
  if (last_ && frame.number <= last_->number && frame.device_time <= last_->device_time &&
      frame.device_time > 0.0)
    throw DeviceError("camera", concat("frame ", frame.number, " is not newer than frame ", last_->number),
                      "start the camera anew");
  last_ = Stamp{frame.number, frame.device_time};
  check_depths(frame.image);
  return frame;
}

}  // namespace stonestack::stacking
