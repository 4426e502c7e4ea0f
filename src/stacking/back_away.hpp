#pragma once
#include <functional>

#include "stonestack/hardware/cell.hpp"
#include "stonestack/motion/pick_and_place.hpp"
#include "stonestack/motion/planning_scene.hpp"

/// Private to stacking/: the way out of where the gripper let go of something.
namespace stonestack::stacking {

/// Where the gripper stands too near to something to go anywhere: backs away from it, until it touches.
/// `before` is called before it moves. False where it stands free.
/// @throws DeviceError when it touches, or the arm stops.
bool back_away(Cell& cell, const PlanningScene& scene, const MotionOptions& options,
               const std::function<void()>& before);

/// Opening of the empty gripper that a scene is to be planned with [m]: fingers that let a stone go beside
/// another were opened no further than there was clearance.
[[nodiscard]] double present_opening(const Cell& cell, const GripperModel& gripper);

}  // namespace stonestack::stacking
