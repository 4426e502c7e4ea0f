#pragma once

#include "stonestack/core/rooms.hpp"

namespace stonestack::emulators {

/// Speed along a path: up, steady, down. From and to rest, except for `brake`, which starts at speed.
struct Profile {
  double length = 0.0;  ///< distance or angle [m or rad]
  double speed = 0.0;   ///< of the steady part
  double rise = 0.0;    ///< [s]
  double steady = 0.0;  ///< [s]
  double fall = 0.0;    ///< [s]

  [[nodiscard]] double duration() const { return rise + steady + fall; }
  /// Displacement after `t` seconds.
  [[nodiscard]] double displacement(double t) const;
};

/// As fast as `speed` and `acceleration` allow.
[[nodiscard]] Profile make_profile(double length, double speed, double acceleration);
/// In `seconds`, a quarter of them for getting up to speed and a quarter for stopping.
[[nodiscard]] Profile make_timed_profile(double length, double seconds);
/// From `speed` to rest.
[[nodiscard]] Profile make_brake(double speed, double acceleration);

}  // namespace stonestack::emulators
