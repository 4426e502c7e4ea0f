#pragma once
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/hardware/cell_file.hpp"
#include "stonestack/kinematics/hand_eye.hpp"
#include "stonestack/stone/catalogue.hpp"

#pragma GCC visibility push(default)

namespace stonestack::stacking {

/// Result of one check of a cell.
struct CellCheck {
  /// Result of one check.
  enum class Verdict {
    kPassed,
    kNote,    ///< passed, but there is something to know or to do before a run
    kFailed,  ///< `text` says what is wrong and what to do
  };
  std::string device;                  ///< "arm"
  std::string step;                    ///< "RTDE"
  Verdict verdict = Verdict::kPassed;  ///< result of the check
  std::string text;                    ///< what was found
};
/// "FAIL  arm, RTDE: UR RTDE at 192.168.1.2:30004: ..."
[[nodiscard]] std::string to_text(const CellCheck& check);

/// Checks of a cell, in order.
struct CellReport {
  std::vector<CellCheck> checks;  ///< checks in the order in which they were made
  /// Number of checks that failed.
  [[nodiscard]] int failed() const;
};
/// JSON text of schema stonestack.doctor/1.
[[nodiscard]] std::string cell_report_json(const CellReport& report);

/// Options of `check_cell`.
struct CellCheckOptions {
  int frames = 2;                                  ///< depth frames to take, at least 2
  std::function<void(const CellCheck&)> on_check;  ///< called after each check; empty: not called
};
/// Checks every device of a cell, step by step, and the hand-eye calibration by a view of the table. Moves
/// nothing.
/// @throws Interrupted
[[nodiscard]] CellReport check_cell(const CellConfig& cell, const CellCheckOptions& options = {});

/// Pose of the arm in which a cell is shown, and what its camera sees then.
struct CellPose {
  std::string name;               ///< "start", "view of the field", "view of the site"
  Joints q = Joints::Zero();      ///< joint angles [rad]
  Pose T_W_C = Pose::Identity();  ///< pose of the camera
  /// Where the corners of the image meet the table, in order, or end in the air. Empty: no camera is named.
  std::vector<Eigen::Vector3d> p_W_seen;
};
/// A cell as its file describes it, before anything is connected.
struct CellPreview {
  RobotModel robot;                        ///< within the cell's limits
  CellLayout layout;                       ///< mounts, field, site and obstacles
  std::optional<CameraIntrinsics> camera;  ///< empty: the file names no camera
  bool camera_is_assumed = false;          ///< true: the camera itself knows its lens, the file does not
  std::vector<CellPose> poses;             ///< the start, and the views of field and site that can be reached
  /// Outline of the part of the table that the gripper reaches while it points down, about the base.
  std::vector<Eigen::Vector2d> p_W_reach;
  std::vector<Eigen::Vector2d> p_W_too_near;  ///< outline of what is too near to the base, likewise
  CellReport report;                          ///< findings about start, field, site and camera
};
/// Options of `preview_cell`.
struct CellPreviewOptions {
  /// Where the arm stands [rad]; empty: fingers down over the middle of the field, as a simulated arm starts.
  std::optional<Joints> q_start;
  bool simulated = false;  ///< the devices are simulated, and get their ports when they are served
};
/// Checks what can be known of a cell before anything is connected or moves: whether the arm stands free at
/// its start, whether the gripper reaches field and site within limits and past obstacles, whether obstacles
/// stand on them, and whether the camera sees them from where a run looks at them.
/// @throws FileError, InvalidArgument for joint angles that the robot does not have
[[nodiscard]] CellPreview preview_cell(const CellConfig& cell, const CellPreviewOptions& options = {});

/// Height and tilt of a plane near the table.
struct TableLevel {
  double height = 0.0;  ///< z in W in the middle of the field [m]
  double tilt = 0.0;    ///< angle of its normal from z of W [rad]
};
/// The table as the fingers touched it, compared with what the camera sees.
struct TouchedTable {
  std::array<Eigen::Vector3d, 3> p_W;  ///< where a finger met the table [m]
  std::array<double, 3> force{};       ///< at contact [N]
  TableLevel touched;                  ///< plane through the three points
  TableLevel seen;                     ///< plane that the camera sees, by its mount
  /// The seen plane above the touched one: difference of their heights, and angle between their normals.
  TableLevel apart;
  std::vector<std::string> problems;  ///< where the two disagree, each with what to do; empty: they agree
  /// Pose of the robot's base with which the touched plane is z = 0 of W.
  Pose T_W_R = Pose::Identity();
};
/// Touches the table at three points with the open and empty gripper, and compares the plane through them
/// with the one that the camera sees. One view of the field is taken first. The three points lie on bare
/// table, free for the gripper, as far apart as the view and the arm's reach allow; the routes to all of them
/// are planned before the first descent. A descent is straight down, at 5 mm/s, guarded by the force at the
/// wrist, and ends 25 mm below where table and camera would have it at the latest. The gripper opens fully
/// first: that is where the tip of the tool is defined. In the end the arm returns to where it stood, if the
/// way is free. The tool is never faster than 0.25 m/s.
/// @throws DeviceError, with the remedy, for a table that is not seen, fewer than three points, a descent
/// that meets nothing, a motion that the arm refuses, and after five minutes; Error (safety stop) when the
/// arm is stopped; Interrupted
[[nodiscard]] TouchedTable touch_table(Cell& cell, const RobotModel& robot);
/// Five lines for a person: points, planes, their difference, and what to do.
[[nodiscard]] std::string to_text(const TouchedTable& table);
/// JSON text of schema stonestack.table/1.
[[nodiscard]] std::string touched_table_json(const TouchedTable& table);

/// Options of `capture_stations`.
struct CaptureOptions {
  int stations = 15;  ///< views of the target to take, at least 4
  std::string
      target;  ///< name of the target; empty: of those that are found the nearest to the field's middle
};
/// Stations of a hand-eye calibration that the arm drives to by itself. The target, a stone or a block of
/// known shape, lies in the field and is left alone: it is found in a view of the field, and then viewed from
/// all sides, 0.45 to 0.6 m away and up to 40 deg off the vertical, with the camera turned about its axis.
/// The gripper stays above the unknown field, and the tool is never faster than 0.25 m/s. The present mount
/// of the layout, from a drawing or measured by a tape, may be wrong by 20 mm and 5 deg. A view
/// that cannot be reached, or does not show the target, is left out. B of the stations is the target's own
/// frame.
/// @param targets   shapes that may lie in the field
/// @throws DeviceError, with the remedy, for a target that is not found, too few views, and after 15 minutes;
/// Error (safety stop) when the arm is stopped; InvalidArgument for an unknown target; Interrupted
[[nodiscard]] HandEyeFile capture_stations(Cell& cell, const RobotModel& robot, const Catalogue& targets,
                                           const CaptureOptions& options = {});
/// A block as the target of a calibration where no stone was scanned: its three sides [m].
/// @throws InvalidArgument for sides under 20 mm or over 0.5 m, or two that differ by less than 10 mm: the
/// sides are what its pose is told by
[[nodiscard]] Catalogue block_target(const Eigen::Vector3d& sides);

}  // namespace stonestack::stacking

#pragma GCC visibility pop
