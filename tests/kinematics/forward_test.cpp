#include "stonestack/kinematics/robot_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/constants.hpp"
#include "kinematics/dh.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::kinematics {
namespace {

// By hand from the DH table: at zero angles the arm lies along -x of the controller's frame, which is +x of
// base_link; d4 and d6 add up sideways, d5 points down.
TEST(Forward, Ur10AtZeroLiesAlongX) {
  const Pose T_R_F = forward(read_robot("ur10"), Joints::Zero());
  EXPECT_NEAR(T_R_F.translation().x(), 0.612 + 0.5723, 1e-12);
  EXPECT_NEAR(T_R_F.translation().y(), 0.163941 + 0.0922, 1e-12);
  EXPECT_NEAR(T_R_F.translation().z(), 0.1273 - 0.1157, 1e-12);
  EXPECT_NEAR(T_R_F.linear().col(2).y(), 1.0, 1e-12) << "the flange points sideways, along +y";
}

// Straight up: both links add to the height; wrist 1 at -90 deg keeps the gripper's sideways offset.
TEST(Forward, Ur10StraightUp) {
  Joints q;
  q << 0, -0.5 * kPi, 0, -0.5 * kPi, 0, 0;
  const Pose T_R_F = forward(read_robot("ur10"), q);
  EXPECT_NEAR(T_R_F.translation().z(), 0.1273 + 0.612 + 0.5723 + 0.1157, 1e-12);
  EXPECT_NEAR(T_R_F.translation().y(), 0.163941 + 0.0922, 1e-12);
  EXPECT_NEAR(T_R_F.translation().x(), 0.0, 1e-12);
}

// The pose of every pick: elbow up, tool down. Forearm level, gripper hanging from it.
TEST(Forward, Ur10ToolDown) {
  Joints q;
  q << 0, -0.5 * kPi, 0.5 * kPi, -0.5 * kPi, -0.5 * kPi, 0;
  const Pose T_R_F = forward(read_robot("ur10"), q);
  EXPECT_NEAR(T_R_F.linear().col(2).z(), -1.0, 1e-12);
  EXPECT_NEAR(T_R_F.translation().x(), 0.5723 + 0.1157, 1e-12);
  EXPECT_NEAR(T_R_F.translation().y(), 0.163941, 1e-12);
  EXPECT_NEAR(T_R_F.translation().z(), 0.1273 + 0.612 - 0.0922, 1e-12);
}

TEST(Forward, TurningTheBaseTurnsThePose) {
  const RobotModel robot = read_robot("ur5e");
  Random random = Random::stream(1, "base turn");
  for (int k = 0; k < 100; ++k) {
    Joints q;
    for (auto& angle : q) angle = random.uniform(-kPi, kPi);
    const double turn = random.uniform(-1.0, 1.0);
    const Pose before = forward(robot, q);
    q[0] += turn;
    const Pose expected = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) * before;
    EXPECT_TRUE(forward(robot, q).isApprox(expected, 1e-12));
  }
}

TEST(Forward, ChainAndDhTableAgreeForEveryRobot) {
  for (const auto& name : robot_names()) {
    const RobotModel robot = read_robot(name);
    Random random = Random::stream(2, name);
    for (int k = 0; k < 1000; ++k) {
      Joints q;
      for (auto& angle : q) angle = random.uniform(-6.0, 6.0);
      const auto off = difference(forward(robot, q), forward_dh(robot, q));
      EXPECT_LT(off.translation, 1e-12) << name;
      EXPECT_LT(off.angle, 1e-7) << name;
    }
    EXPECT_FALSE(robot.calibrated) << name;
  }
}

TEST(Forward, LinkPosesEndAtTheFlange) {
  const RobotModel robot = read_robot("ur16e");
  const Joints q = Joints::LinSpaced(-1.0, 2.0);
  const auto T_R_link = link_poses(robot, q);
  EXPECT_TRUE(T_R_link[0].isApprox(Pose::Identity()));
  EXPECT_TRUE((T_R_link[6] * robot.T_6_F).isApprox(forward(robot, q)));
  // Upper arm and forearm keep their lengths whatever the angles.
  EXPECT_NEAR((T_R_link[3].translation() - T_R_link[2].translation()).norm(), -robot.a2, 1e-12);
}

}  // namespace
}  // namespace stonestack::kinematics
