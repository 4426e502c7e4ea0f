#pragma once

/// Constants of this room with unit and source: numbers that nothing needs to set.
namespace stonestack::search {

// Search: equation (2), paper mode, default mode
inline constexpr double kAreaReference = 0.002;     // m^2, a usual support polygon: A_ref / A; design choice
inline constexpr double kEnergyReference = 0.0002;  // J, that of a stone about to rest; design choice
inline constexpr double kDistanceReference = 0.1;   // m, height of a stone; design choice
inline constexpr double kAttraction = 100.0;  // N, F of paper §3.1, which gives no value; companion paper
inline constexpr double kStableKineticEnergy =
    0.0002;  // J, paper §3.1 without a value; 20 J of a later note filters nothing (measured)
inline constexpr int kContactSteps =
    10;  // over which contacts are collected; paper §3.2 without a value, a later note: 10
inline constexpr double kSlidOff = 0.25;  // m from the start: the stone has slid off the stack; design choice
inline constexpr double kDescentStep =
    0.003;  // m, delta p along x and y; paper §3.2 without a value, design choice
inline constexpr double kDescentTurn = 0.06;  // rad, delta p about each axis; the same
inline constexpr double kMissingContactRise =
    0.5;  // relative rise of the cost assumed where delta p leads to no contact; design choice
inline constexpr double kCleanHeight =
    0.006;  // m, clearance between a new stone and all but the top stone; measured
inline constexpr double kFirmMargin =
    0.04;  // g, a finished tower with less is not firm; measured: bench search --ode
inline constexpr int kFirmRounds =
    2;  // more rounds that may find a firmer tower; measured: bench search --ode

}  // namespace stonestack::search
