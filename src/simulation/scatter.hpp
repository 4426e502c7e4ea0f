#pragma once
#include "simulation/true_world.hpp"

namespace stonestack::simulation {

/// Where loose stones may lie.
struct StoneField {
  Eigen::Vector2d centre;
  Eigen::Vector2d size;    ///< [m]
  double clearance = 0.0;  ///< distance [m] between two stones' outlines seen from above
};

/// Drops the world's stones, one after the other, from just above the table at random places and in random
/// orientations, and lets each come to rest. A stone that rolls out of the field or too near another is
/// dropped again; when one does not fit, all are removed and dropped anew, at last closer together than
/// the field's clearance asks for. Throws InvalidArgument when the field is too small for them.
void scatter_stones(TrueWorld& world, const StoneField& field, std::uint64_t seed);

}  // namespace stonestack::simulation
