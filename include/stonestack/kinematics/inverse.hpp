#pragma once
#include <vector>

#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack {

/// One inverse solution. `branch` is three bits: 1 shoulder right, 2 wrist flipped, 4 elbow down; fixed for a
/// path.
struct IkSolution {
  Joints q;
  int branch = 0;
};

/// All solutions for T_R_F within the joint limits, every 2 pi equivalent included, nearest to `seed` first
/// (largest joint difference, then sum). Empty: out of reach. Clamped at singularities, never NaN.
[[nodiscard]] std::vector<IkSolution> inverse(const RobotModel& robot, const Pose& T_R_F, const Joints& seed);

}  // namespace stonestack
