#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "report/picture.hpp"
#include "stonestack/motion/pick_and_place.hpp"

namespace stonestack::report {

/// One moment of a plan's motions, which follow each other without the time that the gripper takes.
struct PlanMoment {
  double time = 0.0;     ///< time [s] of motion since the start
  std::size_t step = 0;  ///< index in plan.steps
  Joints q = Joints::Zero();
  double tool_speed = 0.0;  ///< speed [m/s] of T's origin
  double clearance =
      0.0;  ///< the smallest distance between things that must not touch [m]; negative: overlap.
            ///< Left out are what is touched on purpose: the fingers and the stone to grasp (or
            ///< let go of), and while it is lifted or set down the stone and what carries it
};

/// Samples the motions every `period` (s) and at every end of a step. The guarded descent is followed to the
/// target, not past it.
/// @throws InvalidArgument for a plan that failed and a period that is not positive.
[[nodiscard]] std::vector<PlanMoment> preview(const PlanningScene& scene, const PickAndPlaceTask& task,
                                              const PickAndPlacePlan& plan, double period);

/// Joint angles, tool speed and clearance over time, the steps marked, as an SVG document.
[[nodiscard]] std::string plan_plot(const PickAndPlacePlan& plan, const std::vector<PlanMoment>& moments);

/// The cell at one moment: the arm, gripper and camera as boxes, every stone where it then is.
[[nodiscard]] std::vector<DrawnMesh> drawn_moment(const PlanningScene& scene, const PickAndPlaceTask& task,
                                                  const PickAndPlacePlan& plan, const PlanMoment& moment);

/// The moments at which steps end, and the first: what pictures of a plan show.
[[nodiscard]] std::vector<PlanMoment> key_moments(const std::vector<PlanMoment>& moments);

}  // namespace stonestack::report
