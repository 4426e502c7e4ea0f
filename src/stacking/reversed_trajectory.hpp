#pragma once
#include "stonestack/kinematics/robot_model.hpp"

/// Private to stacking/: a motion run backwards at the same speed.
namespace stonestack::stacking {

[[nodiscard]] JointTrajectory reversed(const JointTrajectory& trajectory);

/// Path from `q`, where a motion along the trajectory ended early, back to its start: first to the nearest
/// point of the trajectory, then along it.
[[nodiscard]] JointPath way_back(const JointTrajectory& trajectory, const Joints& q);

}  // namespace stonestack::stacking
