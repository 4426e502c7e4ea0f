#pragma once
#include <memory>

#include "hardware/ur/rtde_client.hpp"
#include "hardware/ur/script_writer.hpp"
#include "stonestack/core/options.hpp"
#include "stonestack/hardware/devices.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::hardware {

/// Where a UR controller is and how patient to be with it. Ports are the vendor's.
struct UrArmOptions {
  std::string address;  ///< "192.168.1.10" or a name in the network
  int rtde_port = 30004;
  int primary_port = 30001;    ///< 30001 primary
  int secondary_port = 30002;  ///< tried next
  int realtime_port = 30003;   ///< tried last; 0 leaves one out
  int dashboard_port = 29999;
  double start_timeout = 1.0;  ///< time [s] until a program has written its run id
  double end_grace = 0.3;      ///< time [s] that a program may be over without an end state
  double time_slack = 3.0;     ///< extra time [s]
  double pause_limit = 300.0;  ///< time [s] that a user may pause a motion
  double stop_timeout = 2.0;   ///< time [s] until the arm stands
  /// Checksum of the safety configuration with which motions are allowed, eight hexadecimal digits; empty:
  /// with any.
  std::string safety_checksum;
  std::string serial;  ///< serial number of the arm that may be moved, as the Dashboard says it; empty: any
  RtdeOptions rtde;
  ScriptOptions script;
};
[[nodiscard]] FieldList fields(UrArmOptions& options);

/// A UR arm with a CB3 or e-Series controller. One URScript program a motion, so that the controller keeps
/// the time; a motion has ended when its run id stands in the registers, its program is not running, and its
/// end state is written. After a protective stop, an emergency stop or the like every motion is refused until
/// a person has looked and `rearm` is called. Not tried on hardware.
///
/// Thread-safe: `stop` and `state` may be called while another thread waits in a motion.
class UrArm : public Arm {
 public:
  /// `T_W_R` and `T_F_T` as calibrated. `force_torque` feeds guarded motions; without it they are refused. It
  /// must outlive the arm and is read by the thread that calls `follow_guarded`.
  /// @throws DeviceError: see RtdeClient and PrimaryClient; PolyScope X (version 10) is refused, and a
  /// controller whose safety configuration has another checksum than the options, or none.
  UrArm(const RobotModel& robot, const UrArmOptions& options, const Pose& T_W_R, const Pose& T_F_T,
        ForceTorqueSensor* force_torque = nullptr);
  ~UrArm() override;

  [[nodiscard]] ArmState state() override;
  /// kStopped: protective or emergency stop, paused for too long, moved by hand in a pause, too far from its
  /// path, killed, not done in time, died of an error (with its line). kRefused: not started, nothing has
  /// moved. kLost: the link broke; the controller's watchdog has stopped the arm.
  [[nodiscard]] MotionResult follow(const JointTrajectory& trajectory) override;
  [[nodiscard]] MotionResult follow_guarded(const GuardedMotion& motion) override;
  void stop() override;
  /// Sets the payload and T_F_T and compares what the controller reads back where it does (3.12, 5.5).
  void set_payload(double mass, const Eigen::Vector3d& p_F_com) override;

  /// For a person who has looked: motions are allowed again after a stop.
  /// @throws DeviceError while the cause lasts.
  void rearm();
  [[nodiscard]] UrVersion version() const;
  /// Checksum of the controller's safety configuration; empty where it says none.
  [[nodiscard]] std::optional<std::uint32_t> safety_checksum() const;
  /// Outputs that this controller does not have, so that their checks are left out.
  [[nodiscard]] std::vector<std::string> missing_outputs() const;

 private:
  struct Device;
  std::unique_ptr<Device> device_;
};

}  // namespace stonestack::hardware
