#pragma once
#include "stacking/journal.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/stacking/build_tower.hpp"

/// Private to stacking/: devices that ask somebody before each motion.
namespace stonestack::stacking {

/// Wrappers around the devices of a cell. Nothing moves before `ask` returns true; where it returns false
/// they throw Interrupted. The journal, which may be null, knows the step that has begun.
class SteppedDevices {
 public:
  SteppedDevices(const Cell& cell, const RobotModel& robot, const BeforeMotion& ask, const Journal* journal);
  /// Cell whose arm and gripper ask.
  [[nodiscard]] Cell cell();

 private:
  struct Asking {
    const RobotModel& robot;
    const Pose T_F_T;
    const BeforeMotion& ask;
    const Journal* journal;
    void about(const std::string& name) const;
    void about(const JointTrajectory& trajectory) const;
  };

  class SteppedArm final : public Arm {
   public:
    SteppedArm(Arm& arm, const Asking& asking) : arm_(arm), asking_(asking) {}
    [[nodiscard]] ArmState state() override { return arm_.state(); }
    [[nodiscard]] MotionResult follow(const JointTrajectory& trajectory) override;
    [[nodiscard]] MotionResult carry(const JointTrajectory& trajectory) override;
    [[nodiscard]] MotionResult follow_guarded(const GuardedMotion& motion) override;
    void stop() override { arm_.stop(); }
    void set_payload(double mass, const Eigen::Vector3d& p_F_com) override {
      arm_.set_payload(mass, p_F_com);
    }

   private:
    Arm& arm_;
    const Asking& asking_;
  };

  class SteppedGripper final : public Gripper {
   public:
    SteppedGripper(Gripper& gripper, const Asking& asking) : gripper_(gripper), asking_(asking) {}
    [[nodiscard]] GripperState state() override { return gripper_.state(); }
    GripperState move(double opening, double speed, double force) override;
    void spread(double spacing) override;

   private:
    Gripper& gripper_;
    const Asking& asking_;
  };

  Cell inner_;
  Asking asking_;
  SteppedArm arm_;
  SteppedGripper gripper_;
};

}  // namespace stonestack::stacking
