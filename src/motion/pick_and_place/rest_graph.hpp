#pragma once
#include <vector>

#include "motion/grasp.hpp"
#include "motion/regrasp.hpp"

namespace stonestack::motion {

/// Resting poses of a stone and the grasps that gripper, grip and table allow in each, wherever on an empty
/// table the stone stands and however it is turned about the vertical. Two poses are joined if they share a
/// grasp.
struct RestGraph {
  std::vector<RestPose> rests;
  std::vector<std::vector<int>> grasps;  ///< for each pose: indices into the grasp set, ascending
};
[[nodiscard]] RestGraph make_rest_graph(const PlanningScene& scene, const Stone& stone,
                                        const std::vector<Grasp>& grasps, const MotionOptions& options,
                                        const RegraspOptions& regrasp);

/// Options with the less firm resting poses that are allowed where no firm one leads on.
[[nodiscard]] RegraspOptions with_shaky_rests(RegraspOptions regrasp);

/// Sequences of 1 to `max` poses (indices, none twice) that lead from the grasps `from` to the grasps `to`:
/// neighbours share a grasp. Shortest first; of equal length the one whose scarcest link has most grasps.
[[nodiscard]] std::vector<std::vector<int>> rest_chains(const RestGraph& graph, const std::vector<int>& from,
                                                        const std::vector<int>& to, int max);

/// Returns the elements that both ascending lists have.
[[nodiscard]] std::vector<int> common(const std::vector<int>& a, const std::vector<int>& b);

}  // namespace stonestack::motion
