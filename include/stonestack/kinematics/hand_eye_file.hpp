#pragma once
#include <string>
#include <utility>
#include <vector>

#include "stonestack/kinematics/hand_eye.hpp"

#pragma GCC visibility push(default)

namespace stonestack::kinematics {

/// Stations in a file, YAML:
///
///   schema: stonestack.hand_eye/1
///   camera: on_hand                 # or on_base
///   pairs:
///     - {T_R_F: {x: ..., qw: ...}, T_C_B: {x: ..., qw: ...}}
struct HandEyeFile {
  CameraMount mount = CameraMount::kOnHand;
  std::vector<HandEyePair> pairs;
};
/// Throws FileError naming file, key and value.
[[nodiscard]] HandEyeFile read_hand_eye_pairs(const std::string& path);
void write_hand_eye_pairs(const std::string& path, const HandEyeFile& file);

/// One parameter of an easy_handeye file.
struct EasyHandEyeParameter {
  std::string key;
  std::string value;
  bool is_null = false;    ///< `key: null`
  bool is_quoted = false;  ///< text, even where it looks like a number or a truth value: '007'
  bool operator==(const EasyHandEyeParameter&) const = default;
};

/// The result as the ROS package easy_handeye keeps it (~/.ros/easy_handeye/NAME.yaml): `parameters` and
/// `transformation`, which is T_F_C with eye_on_hand, T_R_C otherwise. Or as easy_handeye2 does
/// (~/.ros2/easy_handeye2/calibrations/NAME.calib): `parameters` with a calibration_type, and `transform`.
struct EasyHandEye {
  bool of_ros2 = false;  ///< in the format of easy_handeye2
  CameraMount mount = CameraMount::kOnHand;
  Pose T_A_C = Pose::Identity();
  /// Every parameter but eye_on_hand or calibration_type as it stood in the file: robot_base_frame, ...
  std::vector<EasyHandEyeParameter> parameters;
};
/// Reads either format. Throws FileError naming file, key and value.
[[nodiscard]] EasyHandEye read_easy_handeye(const std::string& path);
/// Writes what was read unchanged, in its format: keys sorted and text quoted as easy_handeye (PyYAML) does,
/// or in the order of easy_handeye2's message.
void write_easy_handeye(const std::string& path, const EasyHandEye& calibration);

}  // namespace stonestack::kinematics

#pragma GCC visibility pop
