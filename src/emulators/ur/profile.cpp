#include "emulators/ur/profile.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack::emulators {

double Profile::displacement(double t) const {
  t = std::clamp(t, 0.0, duration());
  if (t < rise) return 0.5 * speed * t * t / rise;
  if (t <= rise + steady) return 0.5 * speed * rise + speed * (t - rise);
  const double left = duration() - t;
  return length - (fall > 0 ? 0.5 * speed * left * left / fall : 0.0);
}

Profile make_profile(double length, double speed, double acceleration) {
  Profile profile{length, std::min(speed, std::sqrt(length * acceleration))};
  if (length <= 0) return {};
  profile.rise = profile.fall = profile.speed / acceleration;
  profile.steady = std::max(0.0, length / profile.speed - profile.rise);
  return profile;
}

Profile make_timed_profile(double length, double seconds) {
  constexpr double kRamp = 0.25;
  return {length, length / (seconds * (1 - kRamp)), kRamp * seconds, (1 - 2 * kRamp) * seconds,
          kRamp * seconds};
}

Profile make_brake(double speed, double acceleration) {
  return {0.5 * speed * speed / acceleration, speed, 0.0, 0.0, speed / acceleration};
}

}  // namespace stonestack::emulators
