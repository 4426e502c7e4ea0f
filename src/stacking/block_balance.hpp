#pragma once
#include <span>

#include "physics/coupled_analysis.hpp"
#include "stonestack/stacking/scene_tasks.hpp"

namespace stonestack::stacking {

/// Coupled rigid-block analysis of bodies with their contacts, in the form of the public result. `down_W` is
/// the direction of gravity.
[[nodiscard]] BlockBalance block_balance(std::span<const StaticBody> bodies,
                                         std::span<const BlockContact> contacts, double friction,
                                         const Eigen::Vector3d& down_W);

}  // namespace stonestack::stacking
