#pragma once
#include <span>

#include "search/find_stack.hpp"
#include "stacking/workcell.hpp"
#include "stonestack/stacking/observe.hpp"

/// Private to stacking/: what is seen and is no stone.
namespace stonestack::stacking {

/// Things above the table that belong to none of the stones, as the views show them, or as they were seen
/// before where no view shows that place. What is seen beside a tower and no higher is left to those who view
/// the tower: most of it is the tower's own.
/// @param world stones that were recognised; one that was seen to float is none of them
[[nodiscard]] std::vector<UnknownThing> unknown_objects(const Workcell& workcell, const Views& views,
                                                        const WorldEstimate& world);

/// Things that the views show above the table and that belong to none of the stones, beside the tower too;
/// the largest first. Not what is beyond the reach of what falls off the tower, or at the robot's base.
[[nodiscard]] std::vector<UnknownThing> unknown_things(const Workcell& workcell, const Views& views,
                                                       const std::vector<PlacedStone>& stones);
/// Ground that an obstacle covers, seen from above, in W [m]; empty for one without a shape.
[[nodiscard]] Eigen::AlignedBox2d ground_of(const Obstacle& obstacle);
/// Upright prism with sixteen sides about what is seen of a thing, from the table up.
[[nodiscard]] Obstacle obstacle_about(const UnknownThing& thing, const std::string& name);

/// Obstacles, likewise, for all that the views show above the table, wherever it stands, named after `what`
/// with a number.
[[nodiscard]] std::vector<Obstacle> objects_above_table(const Views& views, const DetectionOptions& options,
                                                        const std::string& what);

/// Drops sightings of stones that were not known to be there and lie where one of `unknown` lay before:
/// nobody has touched it, so it is no stone now if it was none then.
void drop_known_objects(const ShapeList& shapes, const std::vector<StoneIndex>& known,
                        std::span<const Obstacle> unknown, std::vector<Sighting>& sightings);

}  // namespace stonestack::stacking
