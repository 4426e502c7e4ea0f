#pragma once
#include "stonestack/kinematics/joints.hpp"

/// Private to stacking/: a motion run backwards, as fast.
namespace stonestack::stacking {

[[nodiscard]] JointTrajectory reversed(const JointTrajectory& way);

}  // namespace stonestack::stacking
