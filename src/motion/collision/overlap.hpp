#pragma once
#include "stonestack/motion/planning_scene.hpp"

namespace stonestack::motion {

/// True if two objects share space: a convex piece of one and a convex piece of the other touch or overlap.
[[nodiscard]] bool objects_overlap(const SceneObject& a, const SceneObject& b);

}  // namespace stonestack::motion
