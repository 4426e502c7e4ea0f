#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "rooms.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/motion/planning_scene.hpp"

/// Seeded tasks for `stonestack-bench grasp` and `descent`.
namespace stonestack::bench {

/// A generated limestone whose longest side is between `min_extent` and `max_extent` (m).
[[nodiscard]] Stone random_stone(std::uint64_t seed, const std::string& name, double min_extent,
                                 double max_extent);

/// So many of them, 7 to 14 cm long: "limestone 0" and so on.
[[nodiscard]] std::vector<Stone> random_stones(std::uint64_t seed, int count);

/// A random orientation rolled downhill until the centre of mass is at a local low.
[[nodiscard]] Eigen::Quaterniond rest(const Stone& stone, Random& random);
/// The stone with its lowest point at `z` and its centre of mass above `at`.
[[nodiscard]] Pose standing_at(const Stone& stone, const Eigen::Quaterniond& R_W_O, const Eigen::Vector2d& at,
                               double z);
/// Height of the highest point of an object, m.
[[nodiscard]] double top(const SceneObject& object);

/// Up to six loose stones and one at the site; object i is loose stone i, the last object is the tower.
struct GraspProblem {
  PlanningScene scene;
  std::vector<StoneIndex> loose;
};
[[nodiscard]] GraspProblem make_grasp_problem(const std::vector<Stone>& stones, Random& random);

}  // namespace stonestack::bench
