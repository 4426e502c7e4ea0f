#pragma once

#include "stonestack/core/rooms.hpp"

namespace stonestack::simulation {

/// One finger's worm drive: it pushes until its force is reached, then holds its place; nothing pushes it
/// back.
struct FingerDriveState {
  double target = 0.0;  ///< distance [m] from the plane x = 0 of T
  double speed = 0.0;   ///< [m/s]
  double force = 0.0;   ///< [N]
  /// Pushes on when the held stone yields, as the gripper does while rGTO is set: the request stays active,
  /// and only the current limit had stopped the motor (manual 2014, registers rGTO and rFRA).
  bool regrip = true;
  bool holding = false;
};
constexpr double kRegripBelow =
    0.9;  ///< share of the force: a stalled worm drive starts below it; design choice

/// Next place of a finger after `seconds`: straight out, until what stands there presses with its force, or
/// inwards ever slower as its force rises. `force` (N) presses it outwards now.
[[nodiscard]] double next_finger_place(FingerDriveState& drive, double place, double force, double seconds);

}  // namespace stonestack::simulation
