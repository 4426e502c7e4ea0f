#pragma once
#include <string>

#include "stonestack/motion/pick_and_place.hpp"

#pragma GCC visibility push(default)

namespace stonestack::motion {

/// Object that the arm overlaps with these joints, where no motion can begin: "at the start the arm stands in
/// something: forearm and wall overlap".
/// @return empty where it stands in nothing.
[[nodiscard]] std::string start_problem(const PlanningScene& scene, const Joints& q_start);

/// Why a task cannot be meant as it stands, at a small part of what planning costs: the arm starts in
/// something, or the stone, where it lies, reaches more than 8 mm into the table or another object, which is
/// more than measured poses err by.
/// @return empty for a task that may be planned.
[[nodiscard]] std::string scene_problem(const PlanningScene& scene, const PickAndPlaceTask& task);

}  // namespace stonestack::motion

#pragma GCC visibility pop
