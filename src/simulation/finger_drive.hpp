#pragma once

namespace stonestack {

/// One finger's worm drive: it pushes until its force is reached, then holds its place.
struct FingerDriveState {
  double target = 0.0;  ///< m from the plane x = 0 of T
  double speed = 0.0;   ///< m/s
  double force = 0.0;   ///< N
  bool holding = false;
};

/// Next place of a finger after `seconds`: straight out, or inwards ever slower as its force rises. `force`
/// (N) presses it outwards now.
[[nodiscard]] double next_finger_place(FingerDriveState& drive, double place, double force, double seconds);

}  // namespace stonestack
