#pragma once
#include "stonestack/motion/pick_and_place.hpp"
#include "stonestack/motion/planning_scene.hpp"

namespace stonestack::motion {

/// How far (m, 0 to `max`) the tool may go straight down from `q` until gripper or arm come nearer to an
/// object than 1 mm, what the gripper holds left out: so far a guarded descent may search for contact.
/// Fingers that come down on the table are no harm: the guard feels them. `opening` (m) is that between the
/// pads, `object` (or -1) the held stone's index in scene.objects; the gripper is scene.gripper with its
/// spacing. To 1 mm, never more than there is. Throws InvalidArgument for a negative `max`.
[[nodiscard]] double clearance_below(const PlanningScene& scene, const Joints& q, double opening, int object,
                                     double max);

}  // namespace stonestack::motion
