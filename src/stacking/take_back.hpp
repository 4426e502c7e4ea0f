#pragma once
#include "stacking/workcell.hpp"

/// Private to stacking/: what comes first when a run goes on that was broken off in the midst of a motion.
namespace stonestack::stacking {

/// Asks the gripper, and brings it away from what it was about. A stone that it holds goes back along the
/// path on which it came and is set down, guarded, where it was picked. Fingers around a stone that they do
/// not hold are opened and withdrawn. Every step is in the journal before it begins.
/// @param plan that had begun; null: none, so that the gripper should hold nothing
/// @return true if a stone was set down
/// @throws DeviceError, with what a person has to do, where the gripper holds a stone and the arm stands more
/// than 0.05 rad beside the path, and where the arm stops
[[nodiscard]] bool leave_motion(Workcell& workcell, const WorldEstimate& world, const RunMemory& memory,
                                const PickAndPlacePlan* plan, Journal* journal);

}  // namespace stonestack::stacking
