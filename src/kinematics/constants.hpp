#pragma once

/// Constants of this room with unit and source: numbers that nothing needs to set.
namespace stonestack::kinematics {

// Hand-eye calibration
/// rad, between two stations that count as a motion; Tsai and Lenz 1989: larger turns, smaller error
inline constexpr double kMinTurn = 0.17;
/// of the motions' axes: 0 all parallel, 1 evenly spread; design choice
inline constexpr double kMinSpread = 0.2;
/// m and rad, error of one station: weighs translation against rotation; design choice
inline constexpr double kStationTranslation = 0.001, kStationRotation = 0.003;
/// how much better an inverted reading fits before it is pointed out; design choice
inline constexpr double kInvertedRatio = 3.0;

// Refinement of the camera's mount, one sigma along or about each axis
/// m and rad, of the mount as it was calibrated: twice a good calibration, and 0.5 deg; design choice
inline constexpr double kPriorTranslation = 0.002, kPriorRotation = 0.009;
/// m, of a seen mark: detection's median error; measured: bench detection
inline constexpr double kMarkSigma = 0.0006;
/// m, of the seen table 0.15 m beside the view's middle: the sensor's smooth bias; design choice
inline constexpr double kTableSigma = 0.0007;

}  // namespace stonestack::kinematics
