#pragma once

// Constants of this room, with unit and source: numbers that nothing needs to set.
namespace stonestack::simulation {

/// Step of the true world, s; finer while the fingers touch a stone. Measured: docs/measurements.md, Contact.
inline constexpr double kWorldStep = 0.001;

}  // namespace stonestack::simulation
