#pragma once
#include <numbers>

namespace stonestack::core {

inline constexpr double kGravity = 9.81;                   ///< [m/s^2]
inline constexpr double kPi = std::numbers::pi;            ///< half a turn [rad]
inline constexpr double kTwoPi = 2.0 * std::numbers::pi;   ///< a turn [rad]
inline constexpr double kDegree = std::numbers::pi / 180;  ///< one degree [rad]

}  // namespace stonestack::core
