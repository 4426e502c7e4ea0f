#pragma once
#include "stacking/workcell.hpp"

/// Private to stacking/: what is seen and is no stone.
namespace stonestack::stacking {

/// Obstacles for what the views show above the table that belongs to none of the stones: an upright prism
/// with sixteen sides about what is seen of each, from the table up. What stands at the site is left to those
/// who look at the tower.
[[nodiscard]] std::vector<Obstacle> unknown_objects(const Workcell& workcell, const Views& views,
                                                    const std::vector<PlacedStone>& stones);

}  // namespace stonestack::stacking
