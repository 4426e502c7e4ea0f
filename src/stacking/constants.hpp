#pragma once

// Constants of this room, with unit and source: numbers that nothing needs to set.
namespace stonestack::stacking {

// Holding a stone
/// Share of the stone's weight that the wrist must feel after the lift. Design choice.
inline constexpr double kMinHeldShare = 0.6;
/// Horizontal distance between where the load pulls at the wrist and where it should, m. Design choice.
inline constexpr double kMaxSwing = 0.020;

}  // namespace stonestack::stacking
