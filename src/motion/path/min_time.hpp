#pragma once
#include "motion/timing.hpp"

namespace stonestack::motion {

/// Minimum time [s] in which the path with its corners cut by `limits.blend` can be run within the
/// limits. By another method than `time_path`, as its reference: reachability analysis on a fine grid (Pham
/// and Pham 2018) with derivatives by differences. Slow; tool speed is not regarded.
[[nodiscard]] double min_time(const JointPath& path, const TimingLimits& limits);

}  // namespace stonestack::motion
