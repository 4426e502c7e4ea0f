#pragma once
#include "simulation/true_world.hpp"

namespace stonestack::simulation {

/// The chain of stones at the site: the one on the table nearest to it, then each that rests on the last and
/// on nothing else. Judged by letting every stone of the true world go for `options.seconds` without the arm.
[[nodiscard]] TowerVerdict judge_true_tower(const TrueWorld& world, const Eigen::Vector2d& site,
                                            const StandOptions& options);

/// Waiting and shaking, each in a world of its own that starts from the true one.
[[nodiscard]] Survival try_true_tower(const TrueWorld& world, const Eigen::Vector2d& site,
                                      const SurvivalOptions& options, const StandOptions& bounds);

}  // namespace stonestack::simulation
