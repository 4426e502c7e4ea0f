#pragma once
#include <string>
#include <vector>

#include "stonestack/core/clock.hpp"
#include "stonestack/geometry/obstacle.hpp"
#include "stonestack/hardware/devices.hpp"

#pragma GCC visibility push(default)

namespace stonestack::hardware {

/// Where things are mounted, as calibrated (estimates, not the true values).
struct CellLayout {
  Pose T_W_R = Pose::Identity();                         ///< robot base; z = 0 is the table
  Pose T_F_T = Pose(Eigen::Translation3d(0, 0, 0.264));  ///< tool tip: sensor 41 mm + gripper 223 mm
  Pose T_T_C = make_default_T_T_C();          ///< camera on the gripper's mount, looking along z of T
  std::string gripper = "robotiq-3f";         ///< gripper: a name that comes with stonestack, or a YAML
  double sensor_mass = 0.65;                  ///< between flange and gripper [kg]: FT150 (an FT300: 0.30)
  double camera_mass = 0.20;                  ///< with bracket and cable [kg]; design choice
  std::string linkage = "parallel";           ///< of the fingers, as motions are planned: or three_finger
  Eigen::Vector2d site{0.70, 0.28};           ///< where the tower goes, m in W
  Eigen::Vector2d field_centre{0.70, -0.18};  ///< where loose stones lie
  Eigen::Vector2d field_size{0.40, 0.50};     ///< [m]
  std::vector<Obstacle> obstacles;            ///< what the arm must not touch beside table and stones
  std::vector<PairPadding> paddings;          ///< how far it stays away from these, where a user asks for it
  /// Pose of the camera at the tool tip in the standard cell.
  [[nodiscard]] static Pose make_default_T_T_C();
};

/// The layout with another gripper (docs/formats.md, Grippers) on the same flange: its tip takes the place of
/// the one before, the camera stays where it is on the flange. An empty name changes nothing.
/// @throws FileError
[[nodiscard]] CellLayout with_gripper(CellLayout layout, const std::string& name);

/// The four devices of a cell and its clock. Non-owning: whoever made them keeps them alive.
struct Cell {
  Arm& arm;                         ///< arm
  Gripper& gripper;                 ///< gripper at the flange
  ForceTorqueSensor& force_torque;  ///< force sensor between flange and gripper
  DepthCamera& camera;              ///< depth camera at the gripper
  Clock& clock;                     ///< clock of the devices: simulated time in a simulated cell
  CellLayout layout;                ///< mounts, field and site
};

}  // namespace stonestack::hardware

#pragma GCC visibility pop
