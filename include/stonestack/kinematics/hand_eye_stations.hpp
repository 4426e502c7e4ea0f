#pragma once
#include <vector>

#include "stonestack/core/random.hpp"
#include "stonestack/kinematics/hand_eye.hpp"

#pragma GCC visibility push(default)

namespace stonestack::kinematics {

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
