#pragma once

// Constants of this room, with unit and source: numbers that nothing needs to set.
namespace stonestack::motion {

// Pick and place
/// Length of the lift straight up after the grasp, m; 8 to 12 cm is usual.
inline constexpr double kLiftHeight = 0.10;
/// Height above the expected contact where the guarded descent starts, m. Design choice.
inline constexpr double kDescentLength = 0.020;
/// Clearance of gripper and arm past the expected contact, m. Design choice.
inline constexpr double kDescentPadding = 0.001;
/// Distance from where it lies or will lie within which a held stone may touch others, m. Design choice.
inline constexpr double kContactZone = 0.015;
/// Speed at which open fingers go down beside a stone, m/s: what a guard of 20 N that hears of a contact
/// after 50 ms stops below a UR10's 150 N. Measured: simulated cell `lab`.
inline constexpr double kGuardedSpeed = 0.05;
/// Speed of the fingers in free space, m/s. Robotiq 3-finger: 0.022 to 0.11.
inline constexpr double kFingerSpeed = 0.08;
/// Speed of the fingers on the stone, m/s. Robotiq 3-finger: 0.022 to 0.11.
inline constexpr double kGripSpeed = 0.03;
/// Opening at kGripSpeed before the gripper opens for the retreat, m. Design choice.
inline constexpr double kLoosen = 0.006;
/// Share of the stone's weight that counts as contact during the guarded descent: what the wrist feels of the
/// arm's own motion grows with the load. Measured: bench descent.
inline constexpr double kThresholdShare = 0.35;
/// Complete plans to choose the quickest from. Measured: bench motion.
inline constexpr int kPlans = 3;

}  // namespace stonestack::motion
