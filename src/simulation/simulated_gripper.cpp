#include <algorithm>
#include <cmath>

#include "simulation/finger_drive.hpp"
#include "simulation/simulated_devices.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::simulation {
namespace {

constexpr double kGripperTick = 0.002;  // s
constexpr double kStalled = 0.15;       // s without motion until the drives report rest
constexpr double kDeadline = 20.0;      // s
constexpr double kSpread = 1.0;         // s, for fingers B and C to draw together or apart; design choice
constexpr double kClosed = 5e-4;        // m, of the opening
constexpr double kPositioned = 5e-7;    // m a tick: slower is rest; the creep towards the force is faster

}  // namespace

GripperState SimulatedGripper::state() {
  GripperState state;
  state.host_time = world_->time();
  state.opening = opening(world_->gripper_pose());
  state.fault = stopped_;
  // A stone that was lost lets the fingers close to the end.
  const auto& drives = world_->finger_drives();
  state.object = object_ && drives &&
                 std::any_of(drives->begin(), drives->end(), [](const auto& d) { return d.holding; });
  state.moving = object_ && !state.object && state.opening > kClosed;  // closing on
  return state;
}

GripperState SimulatedGripper::move(double target, double speed, double force) {
  const GripperModel& gripper = world_->gripper_body().gripper;
  const double max = gripper.max_opening;
  require(std::isfinite(target) && std::isfinite(speed) && std::isfinite(force) && target >= 0 &&
              target <= max + 1e-9,
          "the gripper opens from 0 to ", max, " m, asked for ", target, " m");
  force = std::clamp(force, gripper.min_force, gripper.max_force);
  speed = std::clamp(speed, gripper.min_speed, gripper.max_speed);
  std::array<FingerDriveState, kFingers> drives;
  for (std::size_t f = 0; f < drives.size(); ++f)
    drives[f] = {0.5 * target, 0.5 * speed, f == 0 ? force : force / gripper.against,
                 world_->options().regrip};
  world_->drive_fingers(drives);
  object_ = false;
  stopped_.clear();
  double still = 0.0;
  for (double t = 0; still < kStalled; t += kGripperTick) {
    throw_if_interrupted();
    if (t > kDeadline)
      throw DeviceError("simulated gripper", concat("still moving after ", kDeadline, " s"),
                        "check what blocks the fingers");
    const GripperPose from = world_->gripper_pose();
    const Progress progress = world_->wait(kGripperTick);
    stopped_ = progress.stopped;
    if (!stopped_.empty())
      throw DeviceError("simulated gripper", stopped_, "move the arm away and look at the cell");
    double max_move = 0.0;
    for (std::size_t f = 0; f < drives.size(); ++f)
      max_move = std::max(max_move, std::abs(world_->gripper_pose().finger[f] - from.finger[f]));
    still = max_move < kPositioned ? still + kGripperTick : 0.0;
    keeper_->changing(world_->time());
  }
  for (const auto& drive : *world_->finger_drives()) object_ = object_ || drive.holding;
  keeper_->changed(world_->time());
  return state();
}

void SimulatedGripper::spread(double spacing) {
  const GripperModel& gripper = world_->gripper_body().gripper;
  (void)with_spacing(gripper, spacing);  // throws for what cannot be
  const GripperPose from = world_->commanded_pose();
  const double narrowed = gripper.finger_spacing - spacing;
  if (narrowed == from.narrowed) return;
  const auto path = [&](double s) {
    GripperPose gripper_pose = from;
    gripper_pose.narrowed += (narrowed - from.narrowed) * std::clamp(s / kSpread, 0.0, 1.0);
    return gripper_pose;
  };
  stopped_ = world_->advance(kSpread, path).stopped;
  keeper_->changed(world_->time());
  if (!stopped_.empty())
    throw DeviceError("simulated gripper", stopped_, "move the arm away and look at the cell");
}

}  // namespace stonestack::simulation
