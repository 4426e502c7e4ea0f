#pragma once
#include <cstddef>

// Constants of this room, with unit and source: numbers that nothing needs to set.
namespace stonestack::search {

/// Alternatives that are kept for each stone of a plan, for reports: with the chosen one, six. Design choice.
inline constexpr std::size_t kMaxAlternatives = 5;

// Equation (2)
/// Area of a usual support polygon, m^2: A_ref / A. Design choice.
inline constexpr double kAreaReference = 0.002;
/// Kinetic energy of a stone about to rest, J. Design choice.
inline constexpr double kEnergyReference = 0.0002;
/// Height of a stone, m. Design choice.
inline constexpr double kDistanceReference = 0.1;

// Paper mode (section 3)
/// Force F towards the target, N. Paper §3.1 gives no value; companion paper.
inline constexpr double kAttraction = 100.0;
/// Kinetic energy below which a contact pose is stable, J. Paper §3.1 gives no value; the 20 J of a later
/// note filter nothing (measured).
inline constexpr double kStableKineticEnergy = 0.0002;
/// Steps over which contacts are collected. Paper §3.2 gives no value; a later note: 10.
inline constexpr int kContactSteps = 10;
/// Distance from the start, m, at which a stone has slid off the stack. Design choice.
inline constexpr double kSlidOff = 0.25;
/// Step delta p along x and y, m. Paper §3.2 gives no value; design choice.
inline constexpr double kDescentStep = 0.003;
/// Step delta p about each axis, rad. Paper §3.2 gives no value; design choice.
inline constexpr double kDescentTurn = 0.06;
/// Relative rise of the cost assumed where delta p leads to no contact. Design choice.
inline constexpr double kMissingContactRise = 0.5;

// Default mode
/// Clearance between a new stone and all but the top stone, m. Measured.
inline constexpr double kCleanHeight = 0.006;
/// Margin of a firm tower, g. Measured: bench search --ode.
inline constexpr double kFirmMargin = 0.04;
/// Rounds of the search after the first finished tower that is not firm. Measured: bench search --ode.
inline constexpr int kFirmRounds = 2;

// Objective "firm"
/// Margin of a tower that outlasts the shake, g: its acceleration of 2 m/s^2.
inline constexpr double kShakeMargin = 0.2;
/// Share of the displaced worlds in which a tower outlasts the shake that ends the search. Design choice.
inline constexpr double kFirmShare = 0.8;
/// Rounds of the search after the first finished tower. Measured: bench search --objective firm.
inline constexpr int kShakeRounds = 6;

}  // namespace stonestack::search
