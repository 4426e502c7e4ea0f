#pragma once
#include "stonestack/kinematics/joints.hpp"

namespace stonestack {

/// The motion with every change of acceleration spread over a while, so that no joint's jerk exceeds `jerk`
/// (rad/s^3): joint angles are averaged over a sliding window (Biagiotti and Melchiorri 2012, trajectories as
/// outputs of moving-average filters). Velocities and accelerations stay within what they were, start and end
/// are the same, lines stay lines; corners that were cut are cut a little more: by at most the largest
/// acceleration times the window's square over 24 (0.2 mrad for 1.4 rad/s^2 and 50 rad/s^3). It ends later
/// by the window: twice the largest acceleration over `jerk`, 0.06 s for these. A jerk of 0 is no limit: the
/// trajectory stays as it is, as one of a single knot does. Throws InvalidArgument for a jerk that is
/// negative or not finite, or a trajectory that is none.
[[nodiscard]] JointTrajectory limit_jerk(const JointTrajectory& trajectory, double jerk);

}  // namespace stonestack
