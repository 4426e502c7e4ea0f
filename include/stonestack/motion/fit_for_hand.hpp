#pragma once
#include <string>
#include <vector>

#include "stonestack/motion/planning_scene.hpp"
#include "stonestack/stone/catalogue.hpp"

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

/// Draws `count` stones of a catalogue by the seed (paper §4.2: an alternating set of four of six). A stone
/// that gripper or arm cannot carry (`unfit_for_hand`) is not drawn but named in the log.
/// @return indices, sorted; fewer than `count` where fewer are fit.
/// @throws Error (planning failed) if no stone is fit
[[nodiscard]] std::vector<int> draw_stones(const Catalogue& catalogue, int count, int seed,
                                           const GripperModel& gripper, const RobotModel& robot);

}  // namespace stonestack::motion

#pragma GCC visibility pop
