#pragma once
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rooms.hpp"
#include "stacking/execute.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/stacking/observe.hpp"

/// Devices for tests of plan execution: they record commands and answer as scripted.
namespace stonestack::scripted {

using Kind = PlanStep::Kind;
using Status = MotionResult::Status;

/// Records commands; guarded motions end as scripted.
struct ScriptedArm : Arm {
  Joints q = home_joints();
  std::deque<Status> guarded;
  std::vector<std::string> commands;
  bool can_move = true;
  int stops_after = -1;      ///< free motions; negative: never
  JointTrajectory followed;  ///< the last one
  std::function<void()> after_motion = [] {};
  std::function<double(const GuardedMotion&)> mean_force = [](const GuardedMotion&) { return 0.0; };

  ArmState state() override {
    ArmState state;
    state.q = q;
    state.can_move = can_move;
    return state;
  }
  MotionResult follow(const JointTrajectory& trajectory) override {
    commands.push_back("follow");
    followed = trajectory;
    after_motion();
    return {stops_after-- == 0 ? Status::kStopped : Status::kDone, q, 0.0, ""};
  }
  std::optional<Joints> dropped_at;  ///< where the next carry ends because its stone is lost
  MotionResult carry(const JointTrajectory& trajectory) override {
    if (!dropped_at) return follow(trajectory);
    commands.push_back("carry");
    q = *dropped_at;
    dropped_at.reset();
    after_motion();
    return {Status::kDropped, q, 0.0, "scripted"};
  }
  MotionResult follow_guarded(const GuardedMotion& motion) override {
    commands.push_back(motion.threshold > 10 ? "lower" : "descend");
    const Status status = guarded.front();
    guarded.pop_front();
    const double mean = mean_force(motion);
    after_motion();
    return {status, q, 7.0, "scripted", mean};
  }
  void stop() override { commands.push_back("stop"); }
  std::vector<double> payloads;  ///< as they were set [kg]
  double max_payload = 1000.0;   ///< [kg]
  void set_payload(double mass, const Eigen::Vector3d&) override {
    require(mass <= max_payload, "the arm carries ", max_payload, " kg, not ", mass, " kg");
    payloads.push_back(mass);
  }
};

struct ScriptedGripper : Gripper {
  std::vector<std::string>* commands;
  bool object = false;
  int moving = 0;                             ///< states before it reports rest
  double stands_at = GripperState{}.opening;  ///< opening that it reports [m]
  std::string fault;
  explicit ScriptedGripper(std::vector<std::string>* t) : commands(t) {}
  GripperState state() override {
    GripperState state;
    state.moving = moving > 0;
    state.opening = stands_at;
    state.fault = fault;
    state.object = object && moving-- <= 0;
    return state;
  }
  std::function<void(double)> after_move = [](double) {};
  GripperState move(double opening, double, double) override {
    commands->push_back("open");
    after_move(opening);
    return state();
  }
  void spread(double) override { commands->push_back("spread"); }
};

struct ScriptedForce : ForceTorqueSensor {
  Wrench wrench, at_zero;
  Wrench read() override { return {wrench.force - at_zero.force, wrench.torque - at_zero.torque, 0.0}; }
  void zero() override { at_zero = wrench; }
};

struct NoCamera : DepthCamera {
  DepthFrame capture() override { return {}; }
};

struct Bench {
  ScriptedArm arm;
  ScriptedGripper gripper{&arm.commands};
  ScriptedForce force;
  NoCamera camera;
  std::unique_ptr<Clock> clock = make_steady_clock();
  CellLayout layout;
  Cell cell{arm, gripper, force, camera, *clock, layout};
  PlanningScene scene;
  Stone stone;
  PickAndPlacePlan plan;

  Bench() {
    scene.robot = read_robot("ur10");
    scene.T_F_T = layout.T_F_T;
    stone.mass.mass = 1.0;
    for (const Kind kind :
         {Kind::kApproach, Kind::kApproach, Kind::kDescent, Kind::kRelease, Kind::kRetreat}) {
      PlanStep step;
      step.kind = kind;
      step.threshold = kind == Kind::kDescent ? 5.0 : 0.0;
      plan.steps.push_back(step);
    }
    plan.steps[1].threshold = 20.0;  // lowered with the stone in the gripper
  }
  ExecutionResult run(std::deque<Status> guarded) {
    arm.commands.clear();
    arm.payloads.clear();
    force.at_zero = {};
    arm.guarded = std::move(guarded);
    return execute(plan, stone, scene, cell, {}, nullptr);
  }
};

}  // namespace stonestack::scripted
