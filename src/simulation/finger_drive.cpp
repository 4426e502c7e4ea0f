#include "simulation/finger_drive.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack::simulation {
namespace {
constexpr double kCreep = 0.05;  // share of the speed that is left just before the force is reached
}

double next_finger_place(FingerDriveState& drive, double place, double force, double seconds) {
  const double remaining = drive.target - place;
  const double enough = !drive.holding ? drive.force : drive.regrip ? kRegripBelow * drive.force : 0.0;
  drive.holding = remaining < 0 && force >= enough;
  if (drive.holding) return place;
  if (remaining > 0 && -force >= drive.force) return place;  // something stands in the way of opening
  const double ease = remaining < 0 ? std::max(kCreep, 1.0 - force / drive.force) : 1.0;
  const double step = drive.speed * ease * seconds;
  return std::abs(remaining) <= step ? drive.target : place + std::copysign(step, remaining);
}

}  // namespace stonestack::simulation
