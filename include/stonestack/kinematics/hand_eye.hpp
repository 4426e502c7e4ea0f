#pragma once
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "stonestack/core/random.hpp"
#include "stonestack/geometry/pose.hpp"

#pragma GCC visibility push(default)

namespace stonestack::kinematics {

/// Where the camera sits.
enum class CameraMount {
  kOnHand,  ///< it moves with the flange, the target stands still: T_F_C is looked for
  kOnBase,  ///< it stands still, the target moves with the flange: T_R_C is looked for
};
[[nodiscard]] std::string to_text(CameraMount mount);

/// One station of a calibration: where the arm said the flange was and where the camera saw the target. B is
/// the frame of the target (a board).
struct HandEyePair {
  Pose T_R_F = Pose::Identity();
  Pose T_C_B = Pose::Identity();
};

/// How far the target seems to move although it does not: root mean square over the stations.
struct HandEyeResidual {
  double translation = 0.0;  ///< [m]
  double rotation = 0.0;     ///< [rad]
};

/// Result of one method.
struct HandEyeSolution {
  std::string method;             ///< joint, tsai_lenz, park_martin, daniilidis
  Pose T_A_C = Pose::Identity();  ///< A: the flange F with kOnHand, the robot base R with kOnBase
  HandEyeResidual residual;
};

/// All methods, and what looks wrong.
struct HandEyeResult {
  std::vector<HandEyeSolution> solutions;  ///< the joint refinement first
  std::string warning;                     ///< names what looks inverted; empty if nothing does
};

/// Solves A X = X B over all motions between stations: Tsai and Lenz 1989, Park and Martin 1994, Daniilidis
/// 1999 (dual quaternions), and a joint refinement of camera and target pose that starts from the best of
/// them (robust least squares over the stations). Throws InvalidArgument for fewer than three stations, or
/// when their rotations do not fix the result (all about one axis).
[[nodiscard]] HandEyeResult calibrate_hand_eye(std::span<const HandEyePair> pairs, CameraMount mount);

/// How well a known transform agrees with stations.
[[nodiscard]] HandEyeResidual hand_eye_residual(std::span<const HandEyePair> pairs, CameraMount mount,
                                                const Pose& T_A_C);

/// True if the inverse of T_A_C agrees with the stations much better than T_A_C does.
[[nodiscard]] bool looks_inverted(std::span<const HandEyePair> pairs, CameraMount mount, const Pose& T_A_C);

/// Stations in a file, YAML:
///
///   schema: stonestack.hand_eye/1
///   camera: on_hand                 # or on_base
///   pairs:
///     - {T_R_F: {x: ..., qw: ...}, T_C_B: {x: ..., qw: ...}}
struct HandEyeFile {
  CameraMount mount = CameraMount::kOnHand;
  std::vector<HandEyePair> pairs;
  std::string path = {};  ///< where it was read; empty: nowhere
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
/// `transformation`, which is T_F_C with eye_on_hand, T_R_C otherwise.
struct EasyHandEye {
  CameraMount mount = CameraMount::kOnHand;
  Pose T_A_C = Pose::Identity();
  /// Every parameter but eye_on_hand as it stood in the file: robot_base_frame, tracking_base_frame, ...
  std::vector<EasyHandEyeParameter> parameters;
};
/// Throws FileError naming file, key and value.
[[nodiscard]] EasyHandEye read_easy_handeye(const std::string& path);
/// Writes what was read unchanged, keys sorted and text quoted as easy_handeye (PyYAML) does.
void write_easy_handeye(const std::string& path, const EasyHandEye& calibration);

/// Errors of a simulated arm and camera, standard deviations of each station.
struct HandEyeNoise {
  double arm_translation = 0.0002;     ///< [m]
  double arm_rotation = 0.0003;        ///< [rad]
  double target_translation = 0.0003;  ///< of a board half a metre away [m]
  double target_rotation = 0.0010;     ///< [rad]
};

/// Stations of a hand with a camera that looks at a board on the table from all sides, 0.4 to 0.7 m away and
/// up to 54 deg off its normal, turned about its axis: what to record for a calibration. With kOnBase the
/// board is in the hand.
[[nodiscard]] std::vector<HandEyePair> simulate_hand_eye(const Pose& T_A_C, CameraMount mount, int count,
                                                         const HandEyeNoise& noise, Random random);

}  // namespace stonestack::kinematics

#pragma GCC visibility pop
