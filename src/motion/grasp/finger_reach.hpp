#pragma once
#include "stonestack/motion/planning_scene.hpp"

/// Private to motion and what plans with it: where fingers stand at an opening, by the planner's model.
namespace stonestack::motion {

// Joints of the Robotiq 3-finger gripper, from its published model (robotiq_3f_gripper_visualization of
// ros-industrial).
inline constexpr double kPalmJoint = 0.1242;       ///< of a finger at the palm, behind the origin of T [m]
inline constexpr double kPadJoint = 0.0381;        ///< behind the pad, from the finger tip [m]
inline constexpr double kPalmJointAside = 0.0455;  ///< of the palm's joint from the middle [m]
inline constexpr double kPadJointAside = 0.0111;   ///< of the pad's joint from the pad's face [m]
inline constexpr double kLinkInside = 0.005;  ///< thickness of the finger inside of the line of joints [m]

/// z in T of the finger tips with the pads `opening` apart [m]: 0 for kParallel, an arc by a short table for
/// kThreeFinger. Openings beyond the gripper's count as its ends.
[[nodiscard]] double tip_advance(const GripperModel& gripper, double opening);
/// Largest `tip_advance` of the openings between the two: how far the tips come while the fingers close from
/// one to the other.
[[nodiscard]] double furthest_tip(const GripperModel& gripper, double opening, double other);
/// Distance of a finger's inner side from the middle at `z` of T behind the pad, with the pads `opening`
/// apart [m]: a finger of kThreeFinger leans from the palm's joint to the one behind its pad.
[[nodiscard]] double finger_inside(const GripperModel& gripper, double opening, double z);
/// Centre of a box in T with the pads `opening` apart.
[[nodiscard]] Eigen::Vector3d box_centre(const GripperModel& gripper, const GripperBox& box, double opening);

}  // namespace stonestack::motion
