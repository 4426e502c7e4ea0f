#pragma once

// Constants of this room, with unit and source: numbers that nothing needs to set.
namespace stonestack::kinematics {

// Hand-eye calibration
/// Rotation between two stations that count as a motion, rad. Tsai and Lenz 1989: larger turns, smaller
/// error.
inline constexpr double kMinTurn = 0.17;
/// Spread of the motions' axes: 0 all parallel, 1 evenly spread. Design choice.
inline constexpr double kMinSpread = 0.2;
/// Error of one station, m and rad: weighs translation against rotation. Design choice.
inline constexpr double kStationTranslation = 0.001, kStationRotation = 0.003;
/// Ratio by which an inverted reading must fit better to be pointed out. Design choice.
inline constexpr double kInvertedRatio = 3.0;
// Refinement of the camera's mount, one sigma along or about each axis
/// Error of the mount as it was calibrated, m and rad: twice a good calibration, and 0.5 deg. Design choice.
inline constexpr double kPriorTranslation = 0.002, kPriorRotation = 0.009;
/// Table against its nominal plane, m and rad: setting up table and robot by hand. Design choice.
inline constexpr double kPriorTableHeight = 0.003, kPriorTableTilt = 0.006;
/// Error of a seen mark, m: detection's median error. Measured: bench detection.
inline constexpr double kMarkSigma = 0.0006;
/// Error of the seen table 0.15 m beside the view's middle, m: the sensor's smooth bias. Design choice.
inline constexpr double kTableSigma = 0.0007;

}  // namespace stonestack::kinematics
