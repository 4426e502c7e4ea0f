#pragma once
#include <cstddef>
#include <vector>

#include "motion/turn_over.hpp"
#include "stacking/model_again.hpp"
#include "stonestack/geometry/obstacle.hpp"

/// Private to stacking/: a stone that nobody scanned, set down on another of its sides.
namespace stonestack::stacking {

/// Hull of what a cloud's points cover and of the table below them, in W. The cloud has a point at least.
[[nodiscard]] Mesh hull_to_table(const Cloud& cloud_C, const Pose& T_W_C);

/// Part of a model that a camera above the table sees while it lies turned by R_W_O.
struct Shown {
  double unseen = 0.0;  ///< area of what was not seen before [m^2]
  double shared = 0.0;  ///< share that was seen before, of all that it sees
};
[[nodiscard]] Shown shown_by(const modelling::ObjectModel& model, const Eigen::Matrix3d& R_W_O);

/// Ways to turn a stone that bring much of what was not seen of it to light: first those in which it cannot
/// fall back, of these those after which both sides share enough seen surface to be joined, of these those
/// that show most; of equal ones those that set the stone down before those that let it fall over. None that
/// was tried before.
[[nodiscard]] std::vector<TurnTo> ways_to_show(const StoneCandidate& candidate);

/// Sets a stone down on another of its sides, or on an edge from which it falls over, so that much of what no
/// view showed comes to light; then looks from above where it lies. It is weighed on the way.
/// @param scene with `candidates` after the obstacles of the layout, in their order
/// @param others objects that no stone was made of
/// @throws DeviceError when the arm stops.
void turn_stone(Cell& cell, const PlanningScene& scene, std::vector<StoneCandidate>& candidates,
                std::size_t stone, const std::vector<Obstacle>& others, const ModelFieldOptions& options,
                Journal* journal);

}  // namespace stonestack::stacking
