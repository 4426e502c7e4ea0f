#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/geometry/pose.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"

#pragma GCC visibility push(default)

namespace stonestack::hardware {

/// Settings of a cell: which devices it has, where they are, and how things are mounted. Private: a program
/// sets them by their names, in a file (data/cells/*.yaml) or as `fields`.
struct CellConfig;
/// robot, arm.*, gripper.*, force_torque.*, camera.*, layout.*, limits.*
[[nodiscard]] FieldList fields(CellConfig& config);
/// Throws InvalidArgument for a quaternion that is not one (length off by more than 1e-3).
[[nodiscard]] CellLayout to_layout(const CellConfig& config);
/// Sets `T_F_C` by the file `hand_eye` (an easy_handeye file, as `stonestack calibrate` writes it), or clears
/// it where none is named. A relative path is sought beside the cell file, ~ is the home folder. Throws
/// FileError, also for a camera that is not on the gripper.
void read_hand_eye(CellConfig& config);
/// The cell's robot within the cell's limits.
/// @throws FileError for either.
[[nodiscard]] RobotModel read_cell_robot(const CellConfig& config);
/// Throws FileError that names the file when it says no `arm.address`.
void require_arm_address(const CellConfig& config);
/// The devices of a cell, connected. Making it moves nothing.
class HardwareCell {
 public:
  /// Throws DeviceError that names the device, its address and what to do, FileError for a cell file that
  /// does not say enough.
  explicit HardwareCell(const CellConfig& config);
  /// The cell of a file.
  explicit HardwareCell(const std::string& path);
  ~HardwareCell();
  /// Devices of the cell and its layout, for the loop.
  [[nodiscard]] Cell cell();
  /// True if `activate_gripper` will move the fingers.
  [[nodiscard]] bool activates_gripper();
  /// Activates the gripper if it is not active: it opens and closes fully, so only with an empty gripper.
  void activate_gripper();

 private:
  struct Devices;
  std::unique_ptr<Devices> devices_;
};

/// State of an arm's controller, as its Dashboard server reports it.
struct ControllerState {
  std::string robot_mode;        ///< "RUNNING", "POWER_OFF", ...
  std::string safety;            ///< "NORMAL", "PROTECTIVE_STOP", ...
  bool program_running = false;  ///< true while a program moves or may move the arm
};
/// Result of `rearm_arm`.
struct Rearming {
  ControllerState before;          ///< as it was found
  std::vector<std::string> steps;  ///< commands that were given, in order; empty: none was needed
  ControllerState after;           ///< as it was left
};
/// Asked before anything is done: the state, its meaning for a person, and the commands that will be given.
using ConfirmRearming = std::function<bool(const ControllerState& state, const std::string& meaning,
                                           const std::vector<std::string>& steps)>;
/// Makes an arm ready for motions after a stop, for a person who has looked: unlocks a protective stop (the
/// controller allows it 5 s after the stop), switches the arm on, releases its brakes, and checks that
/// motions are allowed. A program that still runs is stopped first. Moves nothing itself; brakes that are
/// released let the arm settle by a little.
/// @throws Error (safety stop) where a person must act at the robot (emergency stop, safeguard, fault), with
/// the remedy, and where `confirm` returns false; DeviceError; Interrupted
[[nodiscard]] Rearming rearm_arm(const CellConfig& config, const ConfirmRearming& confirm);
/// "robot RUNNING, safety NORMAL, no program runs"
[[nodiscard]] std::string to_text(const ControllerState& state);
/// JSON text of schema stonestack.rearm/1.
[[nodiscard]] std::string rearming_json(const Rearming& rearming);

/// Writes a hand-eye calibration, camera in the flange, into a cell file and leaves every other character of
/// it as it is, comments included. `calibration` is the file that holds T_F_C, or empty.
///
///   the cell has layout.T_T_C     its numbers are replaced, by T_F_T of the cell
///   the cell has layout.hand_eye  it names `calibration`; without one T_T_C takes its place
///   the cell has neither          hand_eye is added, or T_T_C without `calibration`
///
/// The file is replaced as a whole, by its new text or not at all.
/// @return the line that was written: "layout.T_T_C: {x: ...}"
/// @throws FileError for a file that is no cell, and for one whose text cannot be edited (aliases, several
/// lines in one value): it says the line to write by hand.
std::string write_mount(const std::string& path, const Pose& T_F_C, const std::string& calibration = "");

/// A pose as a cell file has it, to 0.1 um: "{x: 0.0, y: 0.11, z: -0.17, qx: 0.0871557, ...}"
[[nodiscard]] std::string mount_text(const Pose& pose);

}  // namespace stonestack::hardware

#pragma GCC visibility pop
