#pragma once
#include "stonestack/kinematics/robot_model.hpp"

/// Private to stacking/: a motion run backwards, as fast.
namespace stonestack::stacking {

[[nodiscard]] JointTrajectory reversed(const JointTrajectory& trajectory);

}  // namespace stonestack::stacking
