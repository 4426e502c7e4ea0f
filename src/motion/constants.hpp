#pragma once

/// Constants of this room with unit and source: numbers that nothing needs to set.
namespace stonestack::motion {

// Pick and place
inline constexpr double kLift = 0.10;  // m, straight up after the grasp; 8 to 12 cm is usual
inline constexpr double kDescentLength =
    0.020;  // m above the expected contact where the guarded part starts; design choice
inline constexpr double kDescentPadding =
    0.001;  // m, hand and arm to objects, past the expected contact; design choice
inline constexpr double kContactZone =
    0.015;  // m: so near to where it lies or will lie, a held stone may touch others; design choice
inline constexpr double kFingerSpeed = 0.08;  // m/s, opening in free space; Robotiq 3-finger: 0.022 to 0.11
inline constexpr double kGripSpeed = 0.03;    // m/s, closing on the stone and letting go of it; the same
inline constexpr double kLoosen =
    0.006;  // m, opened at kGripSpeed before the hand opens for the retreat; design choice
inline constexpr double kThresholdShare =
    0.35;  // of the stone's weight, contact at the descent: what the arm's own motion makes the wrist feel
           // grows with the mass that hangs there; measured: bench descent

}  // namespace stonestack::motion
