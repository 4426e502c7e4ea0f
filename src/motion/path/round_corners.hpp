#pragma once
#include "motion/collision.hpp"
#include "motion/timing.hpp"

/// Private to motion.
namespace stonestack::motion {

/// How far the corners of a free path may be cut (rad), at most `limits.blend`, so that the path that
/// `time_path` follows is free as well, certified between its points; 0: the motion must stop at corners.
[[nodiscard]] double free_blend(const CollisionChecker& checker, const JointPath& path,
                                const TimingLimits& limits);

}  // namespace stonestack::motion
