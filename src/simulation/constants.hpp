#pragma once

/// Constants of this room with unit and source: numbers that nothing needs to set.
namespace stonestack::simulation {

/// s, step of the true world; finer while the fingers touch a stone; measured: docs/measurements.md, Contact
inline constexpr double kWorldStep = 0.001;

}  // namespace stonestack::simulation
