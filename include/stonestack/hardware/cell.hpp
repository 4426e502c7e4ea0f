#pragma once
#include <vector>

#include "stonestack/core/clock.hpp"
#include "stonestack/geometry/obstacle.hpp"
#include "stonestack/hardware/devices.hpp"

#pragma GCC visibility push(default)

namespace stonestack::hardware {

/// Where things are mounted, as calibrated (what the program believes, not what is true).
struct CellLayout {
  Pose T_W_R = Pose::Identity();                         ///< robot base; z = 0 is the table
  Pose T_F_T = Pose(Eigen::Translation3d(0, 0, 0.264));  ///< tool tip: sensor 41 mm + gripper 223 mm
  Pose T_T_C = make_default_T_T_C();          ///< camera on the gripper's mount, looking along z of T
  double sensor_mass = 0.65;                  ///< between flange and gripper [kg]: FT150 (an FT300: 0.30)
  double camera_mass = 0.20;                  ///< with bracket and cable [kg]; ours
  Eigen::Vector2d site{0.70, 0.28};           ///< where the tower goes, m in W
  Eigen::Vector2d field_centre{0.70, -0.18};  ///< where loose stones lie
  Eigen::Vector2d field_size{0.40, 0.50};     ///< [m]
  std::vector<Obstacle> obstacles;            ///< what the arm must not touch beside table and stones
  std::vector<PairPadding> paddings;          ///< how far it stays away from these, where a user says so
  [[nodiscard]] static Pose make_default_T_T_C();
};

/// The four devices of a cell and its clock. Non-owning: whoever made them keeps them alive.
struct Cell {
  Arm& arm;
  Gripper& gripper;
  ForceTorqueSensor& force_torque;
  DepthCamera& camera;
  Clock& clock;
  CellLayout layout;
};

}  // namespace stonestack::hardware

#pragma GCC visibility pop
