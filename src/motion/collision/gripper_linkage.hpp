#pragma once
#include "stonestack/motion/planning_scene.hpp"

namespace stonestack::motion {

/// The gripper with the fingers of a linkage in place of flat jaws: leaning ones for the 3-finger gripper,
/// the arc of its own file for another. kParallel changes nothing.
[[nodiscard]] GripperModel draw_linkage(GripperModel gripper, Linkage linkage);

}  // namespace stonestack::motion
