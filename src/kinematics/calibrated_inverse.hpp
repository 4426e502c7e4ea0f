#pragma once
#include "kinematics/inverse.hpp"

/// Private to kinematics: inverse solutions of a robot whose axes are as measured, not as drawn.
namespace stonestack::kinematics {

/// Like `inverse_branches` for a calibrated robot; `wanted` is one branch, or -1 for all. Newton's method
/// from the closed form's branches; beside a singularity, where two of them may end in one solution, or a
/// solution may have no branch that leads to it, from other angles of the wrist as well.
[[nodiscard]] IkBranches calibrated_branches(const RobotModel& robot, const Pose& T_R_F, const Joints& seed,
                                             int wanted);
/// In the order of the branch ids.
void sort_by_branch(IkBranches& branches);

}  // namespace stonestack::kinematics
