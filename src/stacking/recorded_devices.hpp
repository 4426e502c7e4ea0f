#pragma once
#include <optional>

#include "stonestack/hardware/cell.hpp"
#include "stonestack/stacking/build_tower.hpp"

/// Private to stacking/: devices that pass every command on, record what arm and gripper did, and refuse
/// readings that cannot be true, from whichever driver they come.
namespace stonestack::stacking {

/// Wrappers around the devices of a cell. They write into a timeline that outlives them, and throw
/// DeviceError for numbers that are not finite or out of range, for an arm that stands elsewhere than its
/// last motion ended, and for a camera's frame that came before or shows next to nothing. A motion that is
/// reported as done and did not reach its end is a stop.
class RecordedDevices {
 public:
  RecordedDevices(const Cell& cell, Timeline& timeline);
  /// Cell with recorded devices.
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
    [[nodiscard]] MotionResult carry(const JointTrajectory& trajectory) override;
    [[nodiscard]] MotionResult follow_guarded(const GuardedMotion& motion) override;
    void stop() override { arm_.stop(); }
    void set_payload(double mass, const Eigen::Vector3d& p_F_com) override;

   private:
    /// Records the motion, and stops an arm that was lost in it.
    [[nodiscard]] MotionResult end_motion(const JointTrajectory& trajectory, double begin,
                                          MotionResult result);
    Arm& arm_;
    Recording& recording_;
    std::optional<Joints> q_at_end_;  ///< of the last motion
  };

  class RecordedGripper final : public Gripper {
   public:
    RecordedGripper(Gripper& gripper, Recording& recording) : gripper_(gripper), recording_(recording) {}
    [[nodiscard]] GripperState state() override;
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

  class CheckedCamera final : public DepthCamera {
   public:
    explicit CheckedCamera(DepthCamera& camera) : camera_(camera) {}
    [[nodiscard]] DepthFrame capture() override;

   private:
    /// Number and time of a frame.
    struct Stamp {
      long number = 0;
      double device_time = 0.0;  ///< [s]
    };
    DepthCamera& camera_;
    std::optional<Stamp> last_;
  };

  Cell inner_;
  Recording recording_;
  RecordedArm arm_;
  RecordedGripper gripper_;
  RecordedSensor force_torque_;
  CheckedCamera camera_;
};

}  // namespace stonestack::stacking
