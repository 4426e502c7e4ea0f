#pragma once
#include <span>
#include <string>
#include <vector>

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

}  // namespace stonestack::kinematics

#pragma GCC visibility pop
