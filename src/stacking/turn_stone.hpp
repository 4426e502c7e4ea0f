#pragma once
#include <cstddef>
#include <vector>

#include "stacking/model_again.hpp"
#include "stonestack/geometry/obstacle.hpp"

/// Private to stacking/: a stone that nobody scanned, set down on another of its sides.
namespace stonestack::stacking {

/// Hull of what a cloud's points cover and of the table below them, in W. The cloud has a point at least.
[[nodiscard]] Mesh hull_to_table(const Cloud& cloud_C, const Pose& T_W_C);

/// Sets a stone down on another of its sides, or on an edge from which it falls over, so that much of what no
/// view showed comes to light; then looks from above where it lies. It is weighed on the way.
/// @param scene with `candidates` after the obstacles of the layout, in their order
/// @param others objects that no stone was made of
/// @throws DeviceError when the arm stops.
void turn_stone(Cell& cell, const PlanningScene& scene, std::vector<StoneCandidate>& candidates,
                std::size_t stone, const std::vector<Obstacle>& others, const ModelFieldOptions& options,
                Journal* journal);

}  // namespace stonestack::stacking
