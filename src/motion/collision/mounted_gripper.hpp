#pragma once
#include "stonestack/motion/planning_scene.hpp"

namespace stonestack::motion {

/// The gripper with its tip at T_F_T on the flange. Its file draws it on a force sensor of 41 mm; what of its
/// fixed boxes but the camera's would lie behind the flange is left out, so that nothing is drawn into the
/// wrist where a thinner sensor is mounted or none. A tool that is tilted against the flange keeps its boxes.
[[nodiscard]] GripperModel mounted_at(GripperModel gripper, const Pose& T_F_T);

}  // namespace stonestack::motion
