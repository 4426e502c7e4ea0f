#pragma once
#include <array>
#include <memory>
#include <optional>
#include <string>

#include "stonestack/hardware/camera/realsense_camera.hpp"
#include "stonestack/hardware/camera/recorded_camera.hpp"
#include "stonestack/hardware/camera/stream_camera.hpp"
#include "stonestack/hardware/camera/v4l2_camera.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/hardware/cell_limits.hpp"
#include "stonestack/hardware/robotiq/ft_sensor.hpp"
#include "stonestack/hardware/robotiq/three_finger_gripper.hpp"
#include "stonestack/hardware/ur/ur_arm.hpp"
#include "stonestack/kinematics/robot_model.hpp"

#pragma GCC visibility push(default)

namespace stonestack::hardware {

/// A pose as a file has it: x, y, z (m), qx, qy, qz, qw.
using PoseNumbers = std::array<double, 7>;

/// One file (data/cells/*.yaml) says which devices a cell has, where they are, and how things are mounted.
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
  double sensor_mass, camera_mass;  ///< in the hand beside the gripper [kg]
  double site_x, site_y, field_x, field_y, field_width, field_depth;  ///< m in W; see CellLayout
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
/// FileError, also for a camera that is not on the hand.
void read_hand_eye(CellConfig& config);
/// The cell's robot within the cell's limits. Throws FileError for either.
[[nodiscard]] RobotModel read_cell_robot(const CellConfig& config);
/// Reads the file; `others` are further groups that it may hold. Throws FileError with file, name and value,
/// also for a word that is none of those that a setting knows, and when both layout.T_T_C and layout.hand_eye
/// are given.
[[nodiscard]] CellConfig read_cell_file(const std::string& path, const FieldList& others = {});

/// Throws FileError that names the file when it says no `arm.address`.
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
  /// Activates the gripper if it is not active: it opens and closes fully, so only with an empty hand.
  void activate_gripper();

 private:
  struct Devices;
  std::unique_ptr<Devices> devices_;
};

}  // namespace stonestack::hardware

#pragma GCC visibility pop
