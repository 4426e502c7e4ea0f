#pragma once
#include <Eigen/Core>
#include <string>

#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/geometry/pose.hpp"
#include "stonestack/kinematics/robot_model.hpp"

#pragma GCC visibility push(default)

namespace stonestack::hardware {

/// State that the arm reports. Times in seconds; `device_time` is the controller's own, `host_time` that of
/// `host_seconds` (in a simulated cell of its clock).
struct ArmState {
  Joints q = Joints::Zero();   ///< joint angles [rad]
  Joints qd = Joints::Zero();  ///< joint speeds [rad/s]
  double device_time = 0.0;    ///< clock of the controller [s]
  double host_time = 0.0;      ///< time at which the host received the state [s]
  double speed_scaling = 1.0;  ///< speed slider and scaling, 0 to 1
  bool can_move = true;        ///< powered, brakes off, no stop of any kind
  std::string stop_reason;     ///< when it cannot
};

/// How a motion ended. kStopped, kRefused and kLost need a person's attention.
struct MotionResult {
  /// Outcome of a motion: done, ended by contact, ended without the contact it was to find, stopped by the
  /// robot, refused before it began, connection lost, or ended because the gripper lost what it held.
  enum class Status { kDone, kContact, kNoContact, kStopped, kRefused, kLost, kDropped };
  Status status = Status::kDone;  ///< outcome of the motion
  Joints q = Joints::Zero();      ///< where the arm stands
  double force = 0.0;             ///< along the guard's direction when it ended [N]
  std::string reason;             ///< for a person
  double mean_force = 0.0;        ///< of a guarded motion, likewise, over the second half of its readings [N]
};

/// A slow motion that ends at contact: the trajectory is followed until the force against it exceeds
/// `threshold` in two samples running. Reaching its end without contact is kNoContact.
struct GuardedMotion {
  JointTrajectory trajectory;  ///< path in joint space
  Eigen::Vector3d n_W_direction =
      -Eigen::Vector3d::UnitZ();  ///< direction of motion; resistance points against it
  double threshold = 5.0;         ///< force [N] above the reading at its start
};

/// A six-joint arm. Every call has a deadline of its own and throws DeviceError when the device does not
/// answer.
class Arm {
 public:
  virtual ~Arm() = default;
  /// Latest state of the arm.
  [[nodiscard]] virtual ArmState state() = 0;
  /// Follows the trajectory to its end. Refuses one that does not start within 0.01 rad of where the arm is.
  [[nodiscard]] virtual MotionResult follow(const JointTrajectory& trajectory) = 0;
  /// Follows the trajectory with an object in the gripper, and stops on the way (kDropped) once the gripper
  /// has lost it. The arms of this library do so; one that does not know its gripper follows to the end.
  [[nodiscard]] virtual MotionResult carry(const JointTrajectory& trajectory) { return follow(trajectory); }
  /// Follows a trajectory until the force guard ends it.
  [[nodiscard]] virtual MotionResult follow_guarded(const GuardedMotion& motion) = 0;
  /// Controlled stop; no motion after it without a new command.
  virtual void stop() = 0;
  /// Mass and centre of mass (in F) of the load on the flange.
  virtual void set_payload(double mass, const Eigen::Vector3d& p_F_com) = 0;
};

/// State that the gripper reports. `opening` in metres between the finger pads.
struct GripperState {
  double opening = 0.155;  ///< distance between the fingers [m]
  bool moving = false;     ///< true while the fingers move
  bool object = false;     ///< stopped by an object while closing
  std::string fault;       ///< empty: none
  double host_time = 0.0;  ///< time by `host_seconds` [s], when it was read; in a simulated cell of its clock
};

/// A gripper whose fingers close on one axis (x of T).
class Gripper {
 public:
  virtual ~Gripper() = default;
  /// Latest state of the gripper.
  [[nodiscard]] virtual GripperState state() = 0;
  /// Moves to an opening (m) with a speed (m/s) and force (N a finger); returns when at rest.
  /// @throws DeviceError on a fault or when it does not come to rest within its deadline.
  virtual GripperState move(double opening, double speed, double force) = 0;
  /// Brings the two fingers that stand side by side (B and C) to `spacing` (m) between their pads, with an
  /// empty gripper; returns when at rest. Throws as `move`.
  virtual void spread(double spacing) = 0;
};

/// Force (N) and torque (Nm) at the sensor, axes of the flange F, what the world does to the tool.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   ///< force on the tool [N], in the frame of the sensor
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  ///< torque on the tool [Nm], in the frame of the sensor
  double device_time = 0.0;                          ///< [s]
  double host_time = 0.0;  ///< time by `host_seconds` [s], when it arrived; in a simulated cell of its clock
};

/// A wrist sensor. A reading older than 50 ms is a DeviceError.
class ForceTorqueSensor {
 public:
  virtual ~ForceTorqueSensor() = default;
  /// Latest reading, minus the zero.
  [[nodiscard]] virtual Wrench read() = 0;
  /// Takes the mean of the next readings at rest as zero.
  virtual void zero() = 0;
};

/// Depth camera of the cell.
class DepthCamera {
 public:
  virtual ~DepthCamera() = default;
  /// A frame exposed after the call.
  [[nodiscard]] virtual DepthFrame capture() = 0;
};

}  // namespace stonestack::hardware

#pragma GCC visibility pop
