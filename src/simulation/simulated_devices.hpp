#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "simulation/sensor_noise.hpp"
#include "simulation/true_world.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/hardware/cell.hpp"

namespace stonestack::simulation {

/// How the cell is really put together, as against how it was calibrated.
struct TrueMounting {
  Pose T_W_R = Pose::Identity();
  Pose T_F_T = Pose::Identity();
  Pose T_T_C = Pose::Identity();
  Joints joint_error = Joints::Zero();       ///< what calibration left over [rad]: true q = reported q + this
  RobotModel robot;                          ///< links as they are
  Joints joint_compliance = Joints::Zero();  ///< of each gear [rad/Nm]
};
/// Draws the errors that the options ask for; those of the arm's joints as large as they ask where it stands
/// at `q`, those of its links as large as they ask over the layout's field and site.
[[nodiscard]] TrueMounting draw_mounting(const CellLayout& assumed, const SimulationOptions& options,
                                         const RobotModel& robot, const Joints& q);
/// Offset of each joint that moves the tool's tip by `tip_error` (m, root of the mean square) at `q` [rad].
[[nodiscard]] double joint_sigma(double tip_error, const RobotModel& robot, const Pose& T_F_T,
                                 const Joints& q);
/// How the tool's tip gives way at reported joints `q`.
[[nodiscard]] Compliance tool_compliance(const TrueMounting& mounting, const Joints& q);

/// Lost motion of six gears: the output follows the encoder at most half the width behind (play operator).
class Backlash {
 public:
  Backlash(double width, const Joints& q) : half_(0.5 * width), output_(q) {}
  /// Output when the encoders have moved on to `q`, straight from where `arrive` was told last.
  [[nodiscard]] Joints output(const Joints& q) const {
    return output_.cwiseMax(q - Joints::Constant(half_)).cwiseMin(q + Joints::Constant(half_));
  }
  void arrive(const Joints& q) { output_ = output(q); }
  [[nodiscard]] const Joints& output() const { return output_; }
  void restore(const Joints& output) { output_ = output; }

 private:
  double half_;  // rad
  Joints output_;
};

/// Names what a link of the arm overlaps, with the reported joints `q`.
[[nodiscard]] std::optional<std::string> find_link_hit(const TrueWorld& world, const TrueMounting& mounting,
                                                       const Joints& q);

/// Keeps the cell for another process whenever its devices have changed it; nothing until `keep` is set.
class CellKeeper {
 public:
  std::function<void()> keep;
  /// Call at the end of each command.
  void changed(double time) {
    last_ = time;
    if (keep) keep();
  }
  /// Call while a command goes on.
  void changing(double time) {
    if (time - last_ >= kInterval) changed(time);
  }

 private:
  static constexpr double kInterval = 0.2;  // s, of the cell's clock
  double last_ = 0.0;
};

/// The world's time.
class SimulatedClock final : public Clock {
 public:
  explicit SimulatedClock(const TrueWorld& world) : world_(&world) {}
  [[nodiscard]] double now() const override { return world_->time(); }

 private:
  const TrueWorld* world_;
};

/// Wrist sensor at the flange: 100 Hz, counts of 0.1 N and 1 mNm, an unknown offset that drifts, white noise,
/// and readings that are late. Feels the weight of the gripper until zeroed and, where the options say so,
/// its inertia as that of a point at its centre of mass; what is held has both of its own.
class SimulatedForceTorque final : public ForceTorqueSensor {
 public:
  SimulatedForceTorque(TrueWorld& world, const TrueMounting& mounting, const SimulationOptions& options);
  /// The sample at the world's time; asked twice at one time it waits for the next sample.
  [[nodiscard]] Wrench read() override;
  /// Mean of 20 samples.
  void zero() override;
  /// The untared reading at the world's time; never waits.
  [[nodiscard]] Wrench measure();
  [[nodiscard]] nlohmann::json kept() const;
  void restore(const nlohmann::json& kept);

 private:
  [[nodiscard]] Wrench sample();
  [[nodiscard]] double drift() const;

  TrueWorld* world_;
  TrueMounting mounting_;
  Random random_;
  bool noisy_;
  Wrench offset_, zero_;
  Eigen::Vector3d n_F_drift_ = Eigen::Vector3d::Zero(), n_F_torque_drift_ = Eigen::Vector3d::Zero();
  double drift_phase_ = 0.0;  // rad
  double last_time_ = -1.0;
};

/// A position-controlled arm, stiff but for the compliance of its gears. It refuses what the driver of a real
/// arm refuses (hardware/trajectory_gate.hpp). It stops, and stays stopped until unlocked, when a link or the
/// gripper hits something, or at 150 N on the gripper.
class SimulatedArm final : public Arm {
 public:
  SimulatedArm(TrueWorld& world, const RobotModel& robot, const TrueMounting& mounting,
               SimulatedForceTorque& force_torque, CellKeeper& keeper, const SimulationOptions& options,
               const Joints& q, const CellLayout& assumed);
  [[nodiscard]] ArmState state() override;
  [[nodiscard]] MotionResult follow(const JointTrajectory& trajectory) override;
  [[nodiscard]] MotionResult carry(const JointTrajectory& trajectory) override;
  [[nodiscard]] MotionResult follow_guarded(const GuardedMotion& motion) override;
  void stop() override {}  // commands return at rest
  /// State that the gripper reports: carries end once it has lost what it holds.
  void set_gripper(const std::function<GripperState()>& state) { gripper_state_ = state; }
  void set_payload(double mass, const Eigen::Vector3d& p_F_com) override;
  /// Acknowledges a protective stop, as a person does at the pendant.
  void unlock() { stop_reason_.clear(); }
  /// Pose of the tool with the reported joints `q`, without load, when each gear lies in the middle of its
  /// play.
  [[nodiscard]] Pose true_T_W_T(const Joints& q) const;
  /// Where it stands; a protective stop is not kept: who goes on has seen to it.
  [[nodiscard]] nlohmann::json kept() const;
  void restore(const nlohmann::json& kept);

 private:
  [[nodiscard]] Pose tool_at(const Joints& output) const;
  [[nodiscard]] std::string refusal(const JointTrajectory& trajectory) const;
  /// `gripper`, where it is given, is asked for as long as it should hold something.
  [[nodiscard]] MotionResult move(const JointTrajectory& trajectory, const GuardedMotion* guard,
                                  const std::function<GripperState()>& gripper = {});
  [[nodiscard]] double resistance(const GuardedMotion& guard);

  TrueWorld* world_;
  RobotModel robot_;
  TrueMounting mounting_;
  SimulatedForceTorque* force_torque_;
  CellKeeper* keeper_;
  Random random_;
  double jitter_sigma_;  // rad
  Pose T_W_R_assumed_, T_F_T_assumed_;
  Joints q_;
  Backlash backlash_;
  Joints jitter_ = Joints::Zero();  // rad, of the motion that ended last
  double payload_ = 0.0;
  std::string stop_reason_;
  std::function<GripperState()> gripper_state_;
};

/// Fingers with a drive that pushes until its force is reached and then holds its place (worm gear). Three
/// have one each: A gives the commanded force, B and C half of it each. Two share one.
class SimulatedGripper final : public Gripper {
 public:
  SimulatedGripper(TrueWorld& world, CellKeeper& keeper) : world_(&world), keeper_(&keeper) {}
  [[nodiscard]] GripperState state() override;
  /// Force and speed are clamped to what the device can (3-finger: 15 to 60 N, 22 to 110 mm/s), as it does
  /// itself.
  GripperState move(double opening, double speed, double force) override;
  void spread(double spacing) override;
  [[nodiscard]] nlohmann::json kept() const;
  void restore(const nlohmann::json& kept);

 private:
  TrueWorld* world_;
  CellKeeper* keeper_;
  bool object_ = false;
  std::string stopped_;  ///< why the last motion was stopped; empty: it was not
};

/// Renders the true meshes, the table and the gripper, and spoils the view as its sensor does.
class SimulatedCamera final : public DepthCamera {
 public:
  SimulatedCamera(TrueWorld& world, const std::vector<Stone>& stones, const TrueMounting& mounting,
                  const SimulationOptions& options);
  [[nodiscard]] DepthFrame capture() override;
  [[nodiscard]] nlohmann::json kept() const;
  void restore(const nlohmann::json& kept);

 private:
  TrueWorld* world_;
  const std::vector<Stone>* stones_;
  TrueMounting mounting_;
  SensorModel sensor_;
  Random random_;
  long number_ = 0;
};

}  // namespace stonestack::simulation
