#pragma once
#include <functional>
#include <stdexcept>

#include "rooms.hpp"
#include "stonestack/hardware/devices.hpp"

/// Devices of a program that ends in the midst of a run.
namespace stonestack::test {

/// Stands for the end of the program: nothing expects it.
struct Killed : std::runtime_error {
  Killed() : std::runtime_error("killed") {}
};

/// Devices whose program ends with the command that follows, or that carries out, a step.
struct MortalArm : Arm {
  Arm& arm;
  std::function<void()> before, after;
  explicit MortalArm(Arm& a) : arm(a) {}
  ArmState state() override { return arm.state(); }
  MotionResult follow(const JointTrajectory& t) override {
    before();
    MotionResult result = arm.follow(t);
    after();
    return result;
  }
  MotionResult follow_guarded(const GuardedMotion& motion) override {
    before();
    MotionResult result = arm.follow_guarded(motion);
    after();
    return result;
  }
  void stop() override { arm.stop(); }
  void set_payload(double mass, const Eigen::Vector3d& p_F) override { arm.set_payload(mass, p_F); }
};
struct MortalGripper : Gripper {
  Gripper& gripper;
  std::function<void()> before, after;
  explicit MortalGripper(Gripper& g) : gripper(g) {}
  GripperState state() override { return gripper.state(); }
  GripperState move(double opening, double speed, double force) override {
    before();
    GripperState result = gripper.move(opening, speed, force);
    after();
    return result;
  }
  void spread(double spacing) override { gripper.spread(spacing); }
};

}  // namespace stonestack::test
