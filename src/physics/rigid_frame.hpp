#pragma once
#include "physics/world.hpp"

namespace stonestack::physics {

/// Principal axes at the centre of mass, T_O_P, and the moments about them, kg m^2.
[[nodiscard]] Pose principal_frame(const MassProperties& mass, Eigen::Vector3d* moments);

/// Velocity that leads from one pose to another in `dt` s.
[[nodiscard]] Twist velocity_between(const Pose& from, const Pose& to, double dt);

}  // namespace stonestack::physics
