#pragma once
#include <span>

#include "motion/collision.hpp"
#include "stonestack/core/random.hpp"

/// Private to motion: OMPL behind one function.
namespace stonestack::motion {

/// Limits of a tree.
struct TreeLimits {
  double resolution = 0.0;  ///< at which edges are certified [rad]; 0: they are only sampled
  long max_motions = 0;     ///< motion checks
  double longest = 0.0;     ///< only samples that a path of this length could pass are drawn [rad]; 0: all
};
struct Tree {
  JointPath path;    ///< from start to a goal, not shortened; empty: none found
  long motions = 0;  ///< checks spent
};
/// A path from `start` to one of `goals` (all free), found by OMPL's RRT-Connect.
/// OMPL's global random generator is not used: samples come from `random`, so threads do not disturb each
/// other. Throws Interrupted.
[[nodiscard]] Tree rrt_connect(const CollisionChecker& checker, const Joints& start,
                               std::span<const Joints> goals, const TreeLimits& limits, Random random);

}  // namespace stonestack::motion
