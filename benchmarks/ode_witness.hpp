#pragma once
#include "rooms.hpp"
#include "stonestack/physics/stack.hpp"

namespace stonestack::bench {

/// How the Open Dynamics Engine judges: an engine that shares nothing with ours but the scans.
struct OdeOptions {
  double friction = 0.1;
  double seconds = 5.0;            ///< simulated
  double step = 0.0005;            ///< s
  double largest_shift = 0.002;    ///< m, of a centre of mass
  double largest_turn = 0.034907;  ///< rad (2 deg)
};
struct OdeVerdict {
  int standing = 0;    ///< stones from the bottom that stayed
  double shift = 0.0;  ///< m, largest of any stone
  double turn = 0.0;   ///< rad
};
/// Lets a stack stand with every stone dynamic: concave meshes of the scans against each other (triangle on
/// triangle), an exact solver (dWorldStep), friction cones cut to four sides along the principal directions.
[[nodiscard]] OdeVerdict stand_in_ode(const ShapeList& shapes, const Stack& stack,
                                      const OdeOptions& options = {});

}  // namespace stonestack::bench
