#pragma once
#include <functional>
#include <optional>
#include <span>

#include "stonestack/core/random.hpp"
#include "stonestack/motion/collision.hpp"

/// Private to motion: OMPL behind one function.
namespace stonestack {

/// A path from `start` to one of `goals` (all free), found by OMPL's RRT-Connect with at most `most_motions`
/// motion checks; not shortened. Edges are certified at `resolution` (rad), or only sampled when that is 0.
/// OMPL's global random generator is not used: samples come from `random`, so threads do not disturb each
/// other.
[[nodiscard]] std::optional<JointPath> rrt_connect(const CollisionChecker& checker, const Joints& start,
                                                   std::span<const Joints> goals, double resolution,
                                                   long most_motions, Random random);

}  // namespace stonestack
