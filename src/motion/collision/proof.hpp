#pragma once
#include <array>

#include "motion/collision/segment.hpp"
#include "stonestack/geometry/pose.hpp"
#include "stonestack/kinematics/robot_model.hpp"

/// Private to motion: the proof behind CollisionChecker::motion_is_free.
namespace stonestack::motion {

struct CollisionShapes;
struct Mover;

/// How far (m) a point of the capsule around `axis` can get, seen from link `base`, while joint k turns by at
/// most `turn[k]` in either direction from where `pose` was taken; the capsule moves with `link`. A turn of
/// one joint takes a point as far as the point is away from its axis, and further by what the joints behind
/// it have moved it before.
[[nodiscard]] double max_shift(const std::array<Pose, 7>& pose, const Joints& turn, const Segment& axis,
                               double reach, std::size_t link, std::size_t base = 0);

/// Distance from the tool's tip to the nearest wall of the cell's workspace, negative outside [m]; infinite
/// where a cell leaves it any.
[[nodiscard]] double workspace_left(const CollisionShapes& shapes, const std::array<Pose, 7>& pose);

/// Height [m] of a mover, whose link is at T_R_link, above the plane n.p + offset = 0.
[[nodiscard]] double height_above(const Eigen::Vector3d& n_R, double offset, const Mover& mover,
                                  const Pose& T_R_link);

/// True if nothing can touch while the joints go straight from `a` to `b`. Pieces of the motion are halved,
/// each half testing only those pairs that its whole left undecided; a pair that is undecided in a piece
/// shorter than `resolution` (rad, largest joint) counts as a collision.
[[nodiscard]] bool is_free_continuously(const CollisionShapes& shapes, const Joints& a, const Joints& b,
                                        double resolution);

}  // namespace stonestack::motion
