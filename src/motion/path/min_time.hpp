#pragma once
#include "motion/timing.hpp"

namespace stonestack::motion {

/// [s] the least time in which the path with its corners cut as `limits.blend` says can be run within the
/// limits. By another way than `time_path`, as its reference: reachability analysis on a fine grid (Pham and
/// Pham 2018) with derivatives by differences. Slow; tool speed is not regarded.
[[nodiscard]] double min_time(const JointPath& path, const TimingLimits& limits);

}  // namespace stonestack::motion
