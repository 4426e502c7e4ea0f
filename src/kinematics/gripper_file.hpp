#pragma once
#include <array>
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/geometry/pose.hpp"

/// Private to the library: a gripper's file (data/grippers/*.yaml). motion/ makes the planner's model of it,
/// hardware/ takes the tool's tip and what the driver needs.
namespace stonestack::kinematics {

/// A box of the gripper as its file has it: GripperBox of motion/.
struct GripperFileBox {
  Eigen::Vector3d size = Eigen::Vector3d::Zero();        ///< edges [m]
  Eigen::Vector3d p_T_centre = Eigen::Vector3d::Zero();  ///< with the fingers closed
  double finger_side = 0.0;
  double spread = 0.0;
  double advance = 0.0;
  bool camera = false;
};

/// Where the finger tips stand at an opening.
struct GripperFileTip {
  double opening = 0.0;  ///< between the pads [m]
  double advance = 0.0;  ///< z in T of the tips [m]
};

/// Figures of a gripper, as its file states them.
struct GripperFile {
  std::string path;  ///< where it was read, for errors
  std::string name;
  int against = 0;                               ///< fingers that face finger A: 1 or 2
  double tip = 0.0;                              ///< of the open fingers from the gripper's mount [m]
  double max_opening = 0.0;                      ///< [m]
  double min_object = 0.0;                       ///< [m]
  double finger_width = 0.0;                     ///< [m]
  double finger_spacing = 0.0;                   ///< of two fingers that face A [m]; 0: one does
  double narrow_spacing = 0.0;                   ///< drawn together [m]; 0: the gripper cannot
  double pad_length = 0.0, pad_thickness = 0.0;  ///< [m]
  double pad_stiffness = 0.0, pad_shear = 0.0;   ///< [N/m^3]
  double friction = 0.0;                         ///< of the pads on stone
  double min_force = 0.0, max_force = 0.0;       ///< of a pad [N]
  double grip_force = 0.0;                       ///< of a pad, in plans [N]
  double min_speed = 0.0, max_speed = 0.0;       ///< of the opening [m/s]
  double open_count = 0.0, closed_count = 0.0;   ///< positions that the gripper reports [count]
  double mass = 0.0;                             ///< [kg]
  double centre_of_mass = 0.0;                   ///< z in T [m], negative
  double payload = 0.0;                          ///< at the finger tips [kg]
  std::vector<GripperFileTip> tips;              ///< rising openings; empty: they do not move along z
  std::vector<GripperFileBox> boxes;             ///< fingers, palm, sensor, camera
};

/// Reads a gripper by the name that comes with stonestack ("robotiq-2f-85") or the path of its YAML. Strict.
/// @throws FileError that names the file, the key, its unit and range, and what may have been meant.
[[nodiscard]] GripperFile read_gripper_file(const std::string& name_or_path);
/// Grippers that come with stonestack.
[[nodiscard]] std::vector<std::string> gripper_file_names();
/// True for a path, not a name.
[[nodiscard]] bool is_gripper_path(const std::string& name_or_path);

}  // namespace stonestack::kinematics
