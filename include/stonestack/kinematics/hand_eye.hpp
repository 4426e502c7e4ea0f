#pragma once
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "stonestack/core/random.hpp"
#include "stonestack/geometry/pose.hpp"

#pragma GCC visibility push(default)

/// A calibration from recorded stations to its report.
namespace stonestack::kinematics {

/// Where the camera sits.
enum class CameraMount {
  kOnHand,  ///< it moves with the flange, the target stands still: T_F_C is looked for
  kOnBase,  ///< it stands still, the target moves with the flange: T_R_C is looked for
};
/// Name of a mount, as files spell it.
[[nodiscard]] std::string to_text(CameraMount mount);

/// One station of a calibration: the flange as reported by the arm and the target as seen by the camera. B is
/// the frame of the target (a board).
struct HandEyePair {
  Pose T_R_F = Pose::Identity();  ///< pose of the flange, from the arm
  Pose T_C_B = Pose::Identity();  ///< pose of the calibration target, seen by the camera
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
  HandEyeResidual residual;       ///< residual over all stations
};

/// Results of all methods, and a warning.
struct HandEyeResult {
  std::vector<HandEyeSolution> solutions;  ///< the joint refinement first
  std::string warning;                     ///< names poses that seem inverted; empty if none does
};

/// Solves A X = X B over all motions between stations: Tsai and Lenz 1989, Park and Martin 1994, Daniilidis
/// 1999 (dual quaternions), and a joint refinement of camera and target pose that starts from the best of
/// them (robust least squares over the stations).
/// @throws InvalidArgument for fewer than three stations, or when their rotations do not fix the result (all
/// about one axis).
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
  CameraMount mount = CameraMount::kOnHand;  ///< mount of the camera at these stations
  std::vector<HandEyePair> pairs;            ///< stations
  std::string path = {};                     ///< where it was read; empty: nowhere
};
/// Throws FileError naming file, key and value.
[[nodiscard]] HandEyeFile read_hand_eye_pairs(const std::string& path);
/// Writes stations as YAML (schema stonestack.hand_eye/1). @throws FileError.
void write_hand_eye_pairs(const std::string& path, const HandEyeFile& file);

/// One parameter of an easy_handeye file.
struct EasyHandEyeParameter {
  std::string key;         ///< name of the parameter
  std::string value;       ///< its value, as the file spells it
  bool is_null = false;    ///< `key: null`
  bool is_quoted = false;  ///< text, even where it looks like a number or a truth value: '007'
  /// True for the same name and the same text.
  bool operator==(const EasyHandEyeParameter&) const = default;
};

/// The result as the ROS package easy_handeye keeps it (~/.ros/easy_handeye/NAME.yaml): `parameters` and
/// `transformation`, which is T_F_C with eye_on_hand, T_R_C otherwise. Or as easy_handeye2 does
/// (~/.ros2/easy_handeye2/calibrations/NAME.calib): `parameters` with a calibration_type, and `transform`.
struct EasyHandEye {
  bool of_ros2 = false;                      ///< in the format of easy_handeye2
  CameraMount mount = CameraMount::kOnHand;  ///< mount that the file states
  Pose T_A_C = Pose::Identity();             ///< pose of the camera in its parent: flange, or robot base
  /// Every parameter but eye_on_hand or calibration_type as it stood in the file: robot_base_frame, ...
  std::vector<EasyHandEyeParameter> parameters;
};
/// Reads either format. Throws FileError naming file, key and value.
[[nodiscard]] EasyHandEye read_easy_handeye(const std::string& path);
/// Writes what was read unchanged, in its format: keys sorted and text quoted as easy_handeye (PyYAML) does,
/// or in the order of easy_handeye2's message.
void write_easy_handeye(const std::string& path, const EasyHandEye& calibration);

/// Errors of a simulated arm and camera, standard deviations of each station.
struct HandEyeNoise {
  double arm_translation = 0.0002;     ///< [m]
  double arm_rotation = 0.0003;        ///< [rad]
  double target_translation = 0.0003;  ///< of a board half a metre away [m]
  double target_rotation = 0.0010;     ///< [rad]
};

/// Stations of a gripper with a camera that looks at a board on the table from all sides, 0.4 to 0.7 m away
/// and up to 54 deg off its normal, turned about its axis: what to record for a calibration. With kOnBase the
/// board is in the gripper.
[[nodiscard]] std::vector<HandEyePair> simulate_hand_eye(const Pose& T_A_C, CameraMount mount, int count,
                                                         const HandEyeNoise& noise, Random random);

/// Comparison of a calibration that exists with the stations.
struct HandEyeCheck {
  std::string path;          ///< of the easy_handeye file
  HandEyeResidual residual;  ///< residual of the other calibration at the stations
  PoseDifference off;        ///< from the new result
  bool inverted = false;     ///< its inverse agrees with the stations
};

/// Calibration from the stations of a file, and what is wrong with it.
struct HandEyeCalibration {
  HandEyeFile stations;               ///< stations that the calibration used
  HandEyeResult result;               ///< result of every method
  HandEyeSolution chosen;             ///< of the method that was asked for
  std::optional<HandEyeCheck> check;  ///< of the file that was named
  std::string uncertainty;            ///< why `chosen` is no calibration; empty if it is one
  std::vector<std::string> warnings;  ///< about `chosen` and `check`
};

/// Options of `calibrate_stations`.
struct HandEyeCalibrationOptions {
  std::string method = "joint";  ///< joint, tsai_lenz, park_martin or daniilidis
  std::string check;             ///< easy_handeye file to compare with the stations; empty: none
};
/// Calibrates by all methods and judges the result of one.
/// @throws FileError if the file of the stations gives no result, or the file to check is of another mount;
/// InvalidArgument if simulated stations give none, or the method has none
[[nodiscard]] HandEyeCalibration calibrate_stations(const HandEyeFile& stations,
                                                    const HandEyeCalibrationOptions& options = {});

/// "residual 0.4 mm, 0.05 deg"
[[nodiscard]] std::string to_text(const HandEyeResidual& residual);
/// "eye.yaml: residual 0.4 mm, 0.05 deg; 0.1 mm and 0.01 deg from the result"
[[nodiscard]] std::string to_text(const HandEyeCheck& check);
/// Table of the methods, a line each; with the errors of simulated stations where their `T_A_C` is known.
[[nodiscard]] std::string calibration_table(const HandEyeCalibration& calibration,
                                            const std::optional<Pose>& true_T_A_C = {});
/// JSON text of schema stonestack.calibrate/1.
[[nodiscard]] std::string calibration_json(const HandEyeCalibration& calibration);
/// Writes the chosen result as an easy_handeye file, with the frame names and other parameters of the file
/// `alternative`, or with those of a UR arm where that is empty.
/// @throws FileError
void write_calibration(const std::string& path, const HandEyeCalibration& calibration,
                       const std::string& alternative = "");

}  // namespace stonestack::kinematics

#pragma GCC visibility pop
