#pragma once
#include <optional>
#include <vector>

#include "stonestack/hardware/cell.hpp"
#include "stonestack/motion/pick_and_place.hpp"

/// Private to stacking/: the route to a view without devices.
namespace stonestack::stacking {

/// `plan_route_to_view` for an arm that stands at `q_start`.
[[nodiscard]] std::optional<JointTrajectory> route_to_view(const CellLayout& layout,
                                                           const PlanningScene& scene, const Joints& q_start,
                                                           const std::vector<Pose>& T_W_C_candidates,
                                                           const MotionOptions& options);

}  // namespace stonestack::stacking
