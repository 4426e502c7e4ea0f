#pragma once

// Constants of this room, with unit and source: numbers that nothing needs to set.
namespace stonestack::stacking {

// Views
/// Height at which the camera points at the site, m: about the middle of a tower of three or four. Design
/// choice.
inline constexpr double kSiteViewHeight = 0.12;
/// Height at which the camera points at the field, m. Design choice.
inline constexpr double kFieldViewHeight = 0.05;

// Holding a stone
/// Share of the stone's weight that the wrist must feel after the lift. Design choice.
// kg/m^3 of what may be stone: tuff has 1500, basalt 3000; a volume of which a side was guessed errs by a
// half at most.
inline constexpr double kLightStone = 1000.0, kHeavyStone = 6000.0;
inline constexpr double kMinHeldShare = 0.6;
/// Horizontal distance between where the load pulls at the wrist and where it should, m. Design choice.
inline constexpr double kMaxSwing = 0.020;

}  // namespace stonestack::stacking
