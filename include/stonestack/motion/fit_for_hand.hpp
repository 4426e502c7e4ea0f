#pragma once
#include <string>

#include "stonestack/motion/planning_scene.hpp"

#pragma GCC visibility push(default)

namespace stonestack::motion {

/// narrowest horizontal width of a stone that stands on a table [m]: over its poses of rest (`rest_poses`)
/// and all turns about the vertical. A hand from above that is to hold it about its middle opens that wide at
/// least. 0 for a stone without a firm pose of rest. Throws InvalidArgument as `rest_poses`.
[[nodiscard]] double least_width_at_rest(const Stone& stone);

/// Why no grasp from above picks the stone up, however it lies: "162 mm across, the fingers open 155 mm";
/// empty if its weight and its width do not stand in the way. Throws InvalidArgument as `rest_poses`.
[[nodiscard]] std::string unfit_for_hand(const Stone& stone, const GripperModel& gripper);

/// Checks the arm that carries gripper and stone, too: "1.7 kg, ur5 carries 5 kg, 3.35 kg of them the hand
/// with sensor and camera".
[[nodiscard]] std::string unfit_for_hand(const Stone& stone, const GripperModel& gripper,
                                         const RobotModel& robot);

/// Names what cannot carry `mass` (kg), and its limit: "the fingers carry 2.5 kg"; empty if all can.
[[nodiscard]] std::string overload(double mass, const GripperModel& gripper, const RobotModel& robot);

}  // namespace stonestack::motion

#pragma GCC visibility pop
