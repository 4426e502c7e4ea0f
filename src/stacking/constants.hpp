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
inline constexpr double kMinHeldShare = 0.6;
/// Horizontal distance between where the load pulls at the wrist and where it should, m. Design choice.
inline constexpr double kMaxSwing = 0.020;

}  // namespace stonestack::stacking
