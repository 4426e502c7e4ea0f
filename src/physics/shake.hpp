#pragma once
#include "physics/rigid_world.hpp"
#include "stonestack/physics/stack.hpp"

namespace stonestack::physics {

/// Shakes a world along a level direction. In the frame of the table the shaking is a gravity that swings.
/// @param direction unit vector, W
/// @param step of the simulation [s]
void shake_world(RigidWorld& world, const Shake& shake, const Eigen::Vector3d& direction, double step);

}  // namespace stonestack::physics
