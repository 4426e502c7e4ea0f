#pragma once
#include "stonestack/motion/planning_scene.hpp"

/// Private to motion and what plans with it: where fingers stand at an opening, by the planner's model.
namespace stonestack::motion {

/// z in T of the finger tips with the pads `opening` apart [m]: 0 for kParallel, an arc by a short table for
/// kThreeFinger. Openings beyond the gripper's count as its ends.
[[nodiscard]] double tip_advance(const GripperModel& gripper, double opening);
/// Largest `tip_advance` of the openings between the two: how far the tips come while the fingers close from
/// one to the other.
[[nodiscard]] double furthest_tip(const GripperModel& gripper, double opening, double other);
/// Centre of a box in T with the pads `opening` apart.
[[nodiscard]] Eigen::Vector3d box_centre(const GripperModel& gripper, const GripperBox& box, double opening);

}  // namespace stonestack::motion
