#pragma once
#include "motion/path/tool_speed.hpp"

/// Private to motion.
namespace stonestack::motion {

/// Times a path under limits.jerk: only the law of time is smooth, the path is that of `rounded`. Lines are
/// run by double S profiles (Biagiotti and Melchiorri 2008, 3.4), between curves that are run at constant
/// speed, on which the joints' velocity, acceleration and jerk are bounded in closed form. `tool` may be
/// null.
[[nodiscard]] JointTrajectory time_with_jerk(const JointPath& path, const TimingLimits& limits,
                                             const ToolLimit* tool);

}  // namespace stonestack::motion
