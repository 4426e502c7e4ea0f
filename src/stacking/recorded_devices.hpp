#pragma once
#include "stonestack/hardware/cell.hpp"
#include "stonestack/stacking/build_tower.hpp"

/// Private to stacking/: devices that pass every command on and record what arm and gripper did.
namespace stonestack::stacking {

/// Wrappers around the devices of a cell. They write into a timeline that outlives them.
class RecordedDevices {
 public:
  RecordedDevices(const Cell& cell, Timeline& timeline);
  /// Cell with recorded arm, gripper and force sensor.
  [[nodiscard]] Cell cell();

 private:
  /// Appends a sample of the state as it is now known.
  struct Recording {
    Clock& clock;
    Timeline& timeline;
    MotionSample now;
    void add(double time);
    void add_motion(const JointTrajectory& trajectory, double begin, const MotionResult& result);
  };

  class RecordedArm final : public Arm {
   public:
    RecordedArm(Arm& arm, Recording& recording) : arm_(arm), recording_(recording) {}
    [[nodiscard]] ArmState state() override;
    [[nodiscard]] MotionResult follow(const JointTrajectory& trajectory) override;
    [[nodiscard]] MotionResult follow_guarded(const GuardedMotion& motion) override;
    void stop() override { arm_.stop(); }
    void set_payload(double mass, const Eigen::Vector3d& p_F_com) override;

   private:
    Arm& arm_;
    Recording& recording_;
  };

  class RecordedGripper final : public Gripper {
   public:
    RecordedGripper(Gripper& gripper, Recording& recording) : gripper_(gripper), recording_(recording) {}
    [[nodiscard]] GripperState state() override { return gripper_.state(); }
    GripperState move(double opening, double speed, double force) override;
    void spread(double spacing) override;

   private:
    Gripper& gripper_;
    Recording& recording_;
  };

  class RecordedSensor final : public ForceTorqueSensor {
   public:
    RecordedSensor(ForceTorqueSensor& sensor, Recording& recording)
        : sensor_(sensor), recording_(recording) {}
    [[nodiscard]] Wrench read() override;
    void zero() override { sensor_.zero(); }

   private:
    ForceTorqueSensor& sensor_;
    Recording& recording_;
  };

  Cell inner_;
  Recording recording_;
  RecordedArm arm_;
  RecordedGripper gripper_;
  RecordedSensor force_torque_;
};

}  // namespace stonestack::stacking
