#pragma once
#include <optional>

#include "rooms.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/search/find_next_pose.hpp"

namespace stonestack::bench {

/// How a stone is put down: one sigma along and about each axis, and the friction of the world it meets.
struct PlacementNoise {
  double shift = 0.0;  ///< along each axis, m
  double turn = 0.0;   ///< about each axis, rad
  double com = 0.0;    ///< of every centre of mass, m
  double friction = 0.1;
  double stands = 5.0;  ///< time [s] simulated afterwards, every stone dynamic
};

/// Puts a stone down beside its target and lets everything come to rest: the stack then, or nothing if a
/// stone fell, moved (1 mm, 1 deg) or touches what it should not.
[[nodiscard]] std::optional<Stack> put_down(const ShapeList& shapes, const Stack& below,
                                            const Placement& target, const PlacementNoise& noise,
                                            Random& random);

/// Puts a stone of a wall down beside its target and lets everything come to rest, wherever that is, as long
/// as it is within 30 mm of where it was: the stack then; without the stone, if it alone went further;
/// nothing if another did.
[[nodiscard]] std::optional<Stack> set_down_in_wall(const ShapeList& shapes, const Stack& below,
                                                    const Placement& target, const PlacementNoise& noise,
                                                    Random& random);

}  // namespace stonestack::bench
