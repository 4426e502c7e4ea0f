#pragma once
#include <optional>
#include <string>

#include "protocol/ur_version.hpp"
#include "stonestack/core/options.hpp"
#include "stonestack/geometry/pose.hpp"
#include "stonestack/kinematics/robot_model.hpp"

/// URScript for one motion each. The controller keeps the time: a program holds the whole trajectory, follows
/// it with servoj at every control step, and stops by itself when the host falls silent. It reports in
/// registers, so that its end differs from the end of any other program:
///
///   output int    24 run id   25 progress (knots passed)   26 end state (ScriptEnd)
///   output double 24..29 pose of the tool at the end, p[x, y, z, rx, ry, rz] in B   30 force, N
///   input int     24 heartbeat (watched at 10 Hz)   25 counter of the streamed force
///   input double  24..26 force on the tool, N, axes of B
///
/// B is the base frame as the controller has it, RobotModel::T_R_D: half a turn about z from R.
/// Controllers before 3.9 (5.3) have only registers 0..23, which fieldbuses share; there the numbers are 24
/// lower and the program reports it.
namespace stonestack::hardware {

/// End state that a program writes.
enum class ScriptEnd {
  kRunning = 0,
  kDone = 1,
  kContact = 2,
  kNoContact = 3,
  kStaleForce = 4,  ///< the streamed force stopped changing its counter
  kFellBehind = 5,  ///< the arm was too far from where the path had it
};

struct ScriptOptions {
  double stop_acceleration = 2.0;  ///< stopj [rad/s^2]
  double heartbeat_rate = 10;      ///< rate [Hz] below which the controller stops the program
  double force_stale = 0.05;  ///< time [s] without a new force sample that stop a guarded motion: as old as a
                              ///< ForceTorqueSensor's reading may be
  int contact_samples = 2;    ///< running, above the threshold
  double comply_time = 0.0;   ///< time [s] of force mode after contact; 0: just stop
};
[[nodiscard]] FieldList fields(ScriptOptions& options);

/// Settings of every program. T_F_T and payload are set by each program, since another program may
/// have changed them.
struct ScriptContext {
  UrVersion version;
  int run = 1;  ///< positive, another one for each program
  Pose T_F_T = Pose::Identity();
  Pose T_W_R = Pose::Identity();                      ///< for the gate: where a program breaks a limit
  std::optional<double> payload;                      ///< empty [kg]: the controller keeps its own
  Eigen::Vector3d p_F_com = Eigen::Vector3d::Zero();  ///< [m]
  ScriptOptions options;
};

/// When a guarded program ends: the force against `n_B_direction` exceeds the force at the start by
/// `threshold` N.
struct ScriptGuard {
  Eigen::Vector3d n_B_direction = -Eigen::Vector3d::UnitZ();
  double threshold = 5.0;
};

/// First of the registers in use: 24, or 0 before 3.9 (5.3).
[[nodiscard]] int first_register(const UrVersion& version);
/// "stonestack_17", also the name in the controller's messages; at most 31 characters.
[[nodiscard]] std::string script_name(int run);

/// The last gate before the wire. Empty if the trajectory may be sent, else what is wrong with it: sizes,
/// numbers that are not finite, times that do not rise from 0, a start far from `q`, and, at every control
/// step, joint limits, speeds, accelerations, the tool's speed and workspace and the arm's fence.
[[nodiscard]] std::string find_fault(const JointTrajectory& trajectory, const Joints& q,
                                     const RobotModel& robot, const ScriptContext& context);

/// Programs. All throw InvalidArgument for numbers that are not finite or out of a field's sense.
[[nodiscard]] std::string write_trajectory(const JointTrajectory& trajectory, const ScriptContext& context);
[[nodiscard]] std::string write_guarded(const JointTrajectory& trajectory, const ScriptGuard& guard,
                                        const ScriptContext& context);
[[nodiscard]] std::string write_stop(const ScriptContext& context);
/// Sets tool centre point and payload, and nothing else.
[[nodiscard]] std::string write_settings(const ScriptContext& context);

/// Line `number` (from 1) of a program without its indentation; empty if there is none.
[[nodiscard]] std::string script_line(const std::string& script, int number);

}  // namespace stonestack::hardware
