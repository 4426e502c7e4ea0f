#pragma once
#include <array>
#include <vector>

#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::kinematics {

/// One inverse solution. `branch` is three bits, fixed along a path that meets no singularity: 1 the
/// shoulder's second solution ("right": the arm reaches over its base), 2 wrist 2 negative ("flipped"), 4
/// elbow negative ("down" while the shoulder bit is 0); all in DH angles.
struct IkSolution {
  Joints q;
  int branch = 0;
};

/// All solutions for T_R_F within the joint limits, every 2 pi equivalent included, nearest to `seed` first
/// (largest joint difference, then sum). Empty: out of reach. At a singularity the arguments are clamped and
/// what is free is taken from the seed, so the result is never NaN; every solution meets T_R_F within 1e-9 (m
/// and rad).
[[nodiscard]] std::vector<IkSolution> inverse(const RobotModel& robot, const Pose& T_R_F, const Joints& seed);

/// At most one solution a branch, in the order of the branch ids.
struct IkBranches {
  std::array<IkSolution, 8> solutions;
  int count = 0;
};

/// The core of `inverse`, without allocation: each branch once, its angles at the 2 pi equivalent nearest to
/// `seed`, joint limits not regarded. None for a pose or seed that is not finite.
[[nodiscard]] IkBranches inverse_branches(const RobotModel& robot, const Pose& T_R_F, const Joints& seed);

/// The solution of one branch that is nearest to `seed` within the limits; false in `found` when the branch
/// does not reach. For following a straight line on one branch.
struct IkOnBranch {
  bool found = false;
  Joints q = Joints::Zero();
};
[[nodiscard]] IkOnBranch inverse_on_branch(const RobotModel& robot, const Pose& T_R_F, const Joints& seed,
                                           int branch);
/// The branch that a configuration is on.
[[nodiscard]] int branch_of(const RobotModel& robot, const Joints& q);

}  // namespace stonestack::kinematics
