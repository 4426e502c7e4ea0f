#include "kinematics/jacobian.hpp"

#include <gtest/gtest.h>

#include "stonestack/core/random.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::kinematics {
namespace {

TEST(Jacobian, MatchesCentralDifferencesForEveryRobot) {
  constexpr double kStep = 1e-6;
  for (const auto& name : robot_names()) {
    const RobotModel robot = read_robot(name);
    Random random = Random::stream(3, name);
    for (int k = 0; k < 50; ++k) {
      Joints q;
      for (auto& angle : q) angle = random.uniform(-3.0, 3.0);
      const Jacobian J = jacobian(robot, q);
      for (int i = 0; i < 6; ++i) {
        const Joints step = kStep * Joints::Unit(i);
        const Pose before = forward(robot, q - step);
        const Pose after = forward(robot, q + step);
        const Eigen::Vector3d velocity = (after.translation() - before.translation()) / (2 * kStep);
        const Eigen::AngleAxisd turn(after.linear() * before.linear().transpose());
        EXPECT_LT((J.block<3, 1>(0, i) - velocity).norm(), 1e-8);
        EXPECT_LT((J.block<3, 1>(3, i) - turn.axis() * turn.angle() / (2 * kStep)).norm(), 1e-8);
      }
    }
  }
}

TEST(Jacobian, ManipulabilityVanishesAtSingularities) {
  const RobotModel robot = read_robot("ur10");
  Joints q;
  q << 0.3, -1.2, 1.4, -1.0, -1.5, 0.4;
  EXPECT_GT(manipulability(robot, q), 1e-3);
  Joints straight = q;
  straight[2] = 0.0;
  EXPECT_LT(manipulability(robot, straight), 1e-12);
  Joints wrist = q;
  wrist[4] = 0.0;
  EXPECT_LT(manipulability(robot, wrist), 1e-12);
}

}  // namespace
}  // namespace stonestack::kinematics
