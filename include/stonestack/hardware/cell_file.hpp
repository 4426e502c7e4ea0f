#pragma once
#include <array>
#include <memory>
#include <optional>
#include <string>

#include "stonestack/core/options.hpp"
#include "stonestack/geometry/pose.hpp"
#include "stonestack/hardware/camera/realsense_camera.hpp"
#include "stonestack/hardware/camera/recorded_camera.hpp"
#include "stonestack/hardware/camera/stream_camera.hpp"
#include "stonestack/hardware/camera/v4l2_camera.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/hardware/robotiq/ft_sensor.hpp"
#include "stonestack/hardware/robotiq/three_finger_gripper.hpp"
#include "stonestack/hardware/ur/ur_arm.hpp"
#include "stonestack/kinematics/robot_model.hpp"

#pragma GCC visibility push(default)

namespace stonestack::hardware {

/// Limits of a cell for its arm, within what the robot can: group `limits` of its file. Lists stand as their
/// text, since they are lists in the file.
struct CellLimits {
  std::string joints;        ///< six of [least, most], degrees; empty: the robot's own
  double joint_speed = 1.0;  ///< share of the robot's own
  double joint_acceleration = 1.0;
  std::array<std::string, 3>
      workspace;  ///< [least, most] of the tool's tip along x, y, z of W, m; empty: no end
};
[[nodiscard]] FieldList fields(CellLimits& limits);

/// The robot as the limits leave it: joint ranges, speeds, accelerations, the tool's workspace. Whoever plans
/// with it keeps them, and so does the gate of the arm that it is given to. `path` is named in errors. Throws
/// FileError for numbers that are not finite, ranges that are empty or wider than the robot's.
[[nodiscard]] RobotModel limit_robot(RobotModel robot, const CellLimits& limits, const Pose& T_W_R,
                                     const Pose& T_F_T, const std::string& path);

/// A pose as a file has it: x, y, z (m), qx, qy, qz, qw.
using PoseNumbers = std::array<double, 7>;

/// One file (data/cells/*.yaml) describes a cell: its devices, their addresses, and how they are mounted.
struct CellConfig {
  std::string file;            ///< where it was read, for errors; empty: nowhere
  std::string robot = "ur10";  ///< ur3 to ur16e or the path of a URDF
  UrArmOptions arm;
  ThreeFingerOptions gripper;
  FtSensorOptions force_torque;
  std::string camera = "stream";  ///< driver: stream, v4l2, realsense or recorded
  StreamCameraOptions stream;
  V4l2CameraOptions v4l2;
  RealsenseCameraOptions realsense;
  RecordedCameraOptions recorded;
  PoseNumbers T_W_R{0, 0, 0, 0, 0, 0, 1};
  PoseNumbers T_F_T;                ///< tool tip in the flange
  PoseNumbers T_T_C;                ///< hand-eye calibration: camera in the tool
  std::string hand_eye;             ///< file of the calibration in place of T_T_C, beside the cell file
  std::optional<Pose> T_F_C;        ///< what `read_hand_eye` read there
  double sensor_mass, camera_mass;  ///< in the gripper beside the gripper [kg]
  double site_x, site_y, field_x, field_y, field_width, field_depth;  ///< in W [m]; see CellLayout
  std::string obstacles_text;                                         ///< the list as it stands in the file
  std::vector<Obstacle> obstacles;                                    ///< what `read_cell_file` read there
  CellLimits limits;
  std::string padding_text;           ///< as obstacles_text
  std::vector<PairPadding> paddings;  ///< what `read_cell_file` read there

  CellConfig();  ///< the layout of CellLayout, no addresses
};
/// robot, arm.*, gripper.*, force_torque.*, camera.*, layout.*, limits.*
[[nodiscard]] FieldList fields(CellConfig& config);
/// Throws InvalidArgument for a quaternion that is not one (length off by more than 1e-3).
[[nodiscard]] CellLayout to_layout(const CellConfig& config);
/// `name`.x to `name`.qw
[[nodiscard]] FieldList pose_fields(const std::string& name, PoseNumbers& numbers, const std::string& source);
/// The pose, likewise; `name` is named in the error.
[[nodiscard]] Pose to_pose(const PoseNumbers& numbers, const std::string& name);
/// Sets `T_F_C` by the file `hand_eye` (an easy_handeye file, as `stonestack calibrate` writes it), or clears
/// it where none is named. A relative path is sought beside the cell file, ~ is the home folder. Throws
/// FileError, also for a camera that is not on the gripper.
void read_hand_eye(CellConfig& config);
/// The cell's robot within the cell's limits. Throws FileError for either.
[[nodiscard]] RobotModel read_cell_robot(const CellConfig& config);
/// Reads the file; `others` are further groups that it may hold. Throws FileError with file, name and value,
/// also for a word that is none of those that a setting knows, and when both layout.T_T_C and layout.hand_eye
/// are given.
[[nodiscard]] CellConfig read_cell_file(const std::string& path, const FieldList& others = {});

/// Throws FileError that names the file when it has no `arm.address`.
void require_arm_address(const CellConfig& config);
/// The camera of `camera.driver`, connected. Throws FileError that names the file for settings that do not
/// do.
[[nodiscard]] std::unique_ptr<DepthCamera> make_camera(const CellConfig& config);

/// The devices of a cell, connected. Making it moves nothing.
class HardwareCell {
 public:
  /// Throws DeviceError that names the device, its address and what to do, FileError for a cell file that
  /// does not say enough.
  explicit HardwareCell(const CellConfig& config);
  ~HardwareCell();
  [[nodiscard]] Cell cell();
  /// Activates the gripper if it is not active: it opens and closes fully, so only with an empty gripper.
  void activate_gripper();

 private:
  struct Devices;
  std::unique_ptr<Devices> devices_;
};

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
