#pragma once

/// Constants of this room with unit and source: numbers that nothing needs to set.
namespace stonestack::stacking {

// Holding a stone
inline constexpr double kMinHeldShare =
    0.6;  // of the stone's weight that the wrist must feel after the lift; design choice
inline constexpr double kMaxSwing =
    0.020;  // m, level, between where the load pulls at the wrist and where it should; design choice

}  // namespace stonestack::stacking
