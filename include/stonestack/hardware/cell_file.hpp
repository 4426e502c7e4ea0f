#pragma once
#include <array>
#include <functional>
#include <memory>
#include <optional>
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
  /// Checksum of the safety configuration that the arm's controller has, as eight hexadecimal digits; empty
  /// where it says none.
  [[nodiscard]] std::string safety_checksum() const;

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

/// A UR controller as it describes itself and what is mounted on its arm.
struct ControllerDescription {
  std::string model;      ///< "UR10"; empty where it does not say (before PolyScope 3.12 and 5.6)
  std::string polyscope;  ///< "3.15.8.106339"
  std::string serial;     ///< serial number of the arm; empty where it does not say (as its model)
  bool e_series = false;  ///< its arm has a force sensor of its own
  ControllerState state;  ///< mode, safety status and program at the time of asking
  std::optional<bool> remote_control;          ///< empty where there is no such mode
  std::optional<double> payload;               ///< of its installation [kg]; empty: it does not say
  std::optional<Eigen::Vector3d> p_F_payload;  ///< centre of mass of that [m]
  std::optional<Eigen::Vector3d> p_F_tip;      ///< its tool centre point [m]
  /// The arm's own DH table, calibration included: theta, d, a, alpha of each joint [m, rad]. Empty where
  /// the script port says none.
  std::optional<std::array<std::array<double, 4>, 6>> dh;
  /// Checksum of the safety configuration, as eight hexadecimal digits. Empty where the script port says
  /// none.
  std::string safety_checksum;
};
/// Asks a controller what it is. Moves and changes nothing. Of the cell only address and ports are used.
/// @throws DeviceError
[[nodiscard]] ControllerDescription describe_controller(const CellConfig& config);
/// Asks the controller at an address or name, on the standard ports.
[[nodiscard]] ControllerDescription describe_controller(const std::string& arm);

/// Order for a new cell file.
struct CellSetup {
  std::string path;                    ///< of the cell file
  std::string arm;                     ///< address or name of the robot's controller
  std::string gripper = "robotiq-3f";  ///< by its name
  std::string gripper_address;         ///< of a gripper with a network socket of its own
  std::string robot;                   ///< ur3 to ur16e; empty: as the controller says
  bool replace = false;                ///< a file that is there may be replaced
};
/// A new cell file, and what a person should know about it.
struct NewCell {
  std::string path;          ///< of the cell file
  std::string robot;         ///< ur3 to ur16e
  std::string robot_file;    ///< with the arm's calibration; empty: it has none
  double calibration = 0.0;  ///< distance of the calibrated flange from the nominal one, arm stretched [m]
  std::vector<std::string> notes;  ///< what does not agree, and what is still to be done
};
/// Refuses a setup that no controller can make good: no address, an unknown gripper, one without its address,
/// a file that is there. Reads and writes nothing else.
/// @throws Error (usage), FileError
void require_sound(const CellSetup& setup);
/// Writes a cell file for the arm that was described, and beside it a robot file with the arm's calibration,
/// where it has one. Both are read back before they get their names.
/// @throws FileError, Error (usage) for an arm that is unknown
NewCell write_new_cell(const CellSetup& setup, const ControllerDescription& controller);
/// JSON text of schema stonestack.setup/1.
[[nodiscard]] std::string new_cell_json(const NewCell& cell, const ControllerDescription& controller);

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

/// Writes the robot's base into a cell file as `layout.T_W_R` and leaves every other character as it is.
/// @return the line that was written
/// @throws FileError as `write_mount`
std::string write_base(const std::string& path, const Pose& T_W_R);

/// A pose as a cell file has it, to 0.1 um: "{x: 0.0, y: 0.11, z: -0.17, qx: 0.0871557, ...}"
[[nodiscard]] std::string mount_text(const Pose& pose);

}  // namespace stonestack::hardware

#pragma GCC visibility pop
