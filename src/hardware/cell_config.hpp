#pragma once
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hardware/camera/realsense_camera.hpp"
#include "hardware/camera/recorded_camera.hpp"
#include "hardware/camera/stream_camera.hpp"
#include "hardware/camera/v4l2_camera.hpp"
#include "hardware/robotiq/ft_sensor.hpp"
#include "hardware/robotiq/three_finger_gripper.hpp"
#include "hardware/robotiq/two_finger_gripper.hpp"
#include "hardware/ur/ur_arm.hpp"
#include "hardware/ur/ur_force_torque.hpp"
#include "stonestack/hardware/cell_file.hpp"

namespace stonestack::hardware {

/// Limits of a cell for its arm, within what the robot can: group `limits` of its file. Lists stand as their
/// text, since they are lists in the file.
struct CellLimits {
  std::string joints;        ///< six of [least, most], degrees; empty: the robot's own
  double joint_speed = 1.0;  ///< share of the robot's own
  double joint_acceleration = 1.0;
  std::array<std::string, 3>
      workspace;                     ///< [least, most] of the tool's tip along x, y, z of W, m; empty: no end
  std::array<std::string, 3> fence;  ///< the same of the whole arm and gripper
  double tool_speed = 1.0;           ///< of the tool's tip [m/s]; motion.tool_speed, the fastest of all steps
};
[[nodiscard]] FieldList fields(CellLimits& limits);

/// The robot as the limits leave it: joint ranges, speeds, accelerations, tool speed, workspace of the tool,
/// fence of the arm. Whoever plans with it keeps them, and so does the gate of the arm that it is given to.
/// `path` is named in errors. Throws FileError for numbers that are not finite, ranges that are empty or
/// wider than the robot's.
[[nodiscard]] RobotModel limit_robot(RobotModel robot, const CellLimits& limits, const Pose& T_W_R,
                                     const Pose& T_F_T, const std::string& path);

/// A pose as a file has it: x, y, z (m), qx, qy, qz, qw.
using PoseNumbers = std::array<double, 7>;

/// One file (data/cells/*.yaml) says which devices a cell has, where they are, and how things are mounted.
struct CellConfig {
  std::string file;                         ///< where it was read, for errors; empty: nowhere
  std::string robot = "ur10";               ///< ur3 to ur16e or the path of a URDF
  std::string gripper_name = "robotiq-3f";  ///< gripper by its name, or a YAML beside the cell file
  UrArmOptions arm;
  std::string gripper_driver = "robotiq_3f";  ///< or robotiq_2f: 2F-85, 2F-140 and Hand-E
  std::string gripper_link = "urcap";         ///< of robotiq_2f: urcap or rtu
  ThreeFingerOptions gripper;                 ///< of either driver, as far as both have them
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
  double sensor_mass, camera_mass;  ///< on the flange, beside the gripper [kg]
  double site_x, site_y, field_x, field_y, field_width, field_depth;  ///< in W [m]; see CellLayout
  std::string obstacles_text;                                         ///< the list as it stands in the file
  std::vector<Obstacle> obstacles;                                    ///< what `read_cell_file` read there
  CellLimits limits;
  std::string padding_text;           ///< as obstacles_text
  std::vector<PairPadding> paddings;  ///< what `read_cell_file` read there

  CellConfig();  ///< the layout of CellLayout, no addresses
  /// With the tip, the driver and the stroke of another gripper; throws FileError.
  explicit CellConfig(const std::string& name);
  /// Whether the arm's own sensor is used.
  [[nodiscard]] bool has_own_sensor() const { return force_torque.link == kOwnSensorLink; }
};
/// `name`.x to `name`.qw
[[nodiscard]] FieldList pose_fields(const std::string& name, PoseNumbers& numbers, const std::string& source);
/// The pose, likewise; `name` is named in the error.
[[nodiscard]] Pose to_pose(const PoseNumbers& numbers, const std::string& name);
/// Reads the file; `others` are further groups that it may hold. Throws FileError with file, name and value,
/// also for a word that is none of those that a setting knows, and when both layout.T_T_C and layout.hand_eye
/// are given.
[[nodiscard]] CellConfig read_cell_file(const std::string& path, const FieldList& others = {});

/// The options of driver robotiq_2f.
[[nodiscard]] TwoFingerOptions two_finger_options(const CellConfig& config);
/// The gripper of `gripper.driver`, connected; moves nothing.
[[nodiscard]] std::unique_ptr<RobotiqGripper> make_gripper(const CellConfig& config);

/// The sensor of `force_torque.link`, connected.
[[nodiscard]] std::unique_ptr<ForceTorqueSensor> make_force_torque(const CellConfig& config);

/// The camera of `camera.driver`, connected. Throws FileError that names the file for settings that do not
/// do.
[[nodiscard]] std::unique_ptr<DepthCamera> make_camera(const CellConfig& config);

}  // namespace stonestack::hardware
