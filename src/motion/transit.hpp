#pragma once
#include <optional>
#include <span>

#include "motion/collision.hpp"
#include "stonestack/motion/pick_and_place.hpp"

namespace stonestack::motion {

/// A joint path from `start` to one of `goals` whose every straight piece `checker.motion_is_free`; empty if
/// start or all goals collide, or if none was found. The straight motion to one of the nearest goals is tried
/// first; then RRT-Connect (OMPL) to all goals at once, again and again for shorter paths until that brings
/// nothing, and the shortest is kept after bounded shortcutting. A goal equal to `start` gives a path of one
/// point. Deterministic for options.seed whatever the load of the machine: the effort is bounded by a number
/// of checks that stands for options.planning_effort; where no path at all was found, for `first_seconds` if
/// that is less. Throws InvalidArgument for numbers that are not finite, Interrupted.
[[nodiscard]] std::optional<JointPath> find_path(const CollisionChecker& checker, const Joints& start,
                                                 std::span<const Joints> goals,
                                                 const MotionOptions& options = {},
                                                 double first_seconds = 1e9);

/// Where the arm stands too near to something for a transit to begin: a straight path of the tool, back out
/// of the gripper's direction or up, at most 12 cm, on which it comes away from what it is near until it is
/// clear of everything by options.approach_padding. The start alone if it is clear already; empty if there is
/// no such path. The gripper is empty and as wide open as in the scene.
[[nodiscard]] std::optional<JointPath> escape_path(const PlanningScene& scene, const Joints& start,
                                                   const MotionOptions& options = {});

/// True if every point of the path is as clear as the one before, or clear of everything, and the last so:
/// what touches at the start is left, and nothing else is met.
[[nodiscard]] bool comes_away(const CollisionChecker& checker, const JointPath& path);

/// Sum of the lengths (rad, of the joint vector) of its pieces.
[[nodiscard]] double length(const JointPath& path);

}  // namespace stonestack::motion
