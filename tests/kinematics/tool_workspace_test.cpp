#include "stonestack/kinematics/robot_model.hpp"

#include <gmock/gmock.h>

#include <limits>

namespace stonestack::kinematics {
namespace {

TEST(ToolWorkspace, IsOfTheTipInTheWorld) {
  RobotModel robot = read_robot("ur10");
  Joints q;
  q << 0.3, -1.2, 1.6, -2.0, -1.5, 0.4;
  EXPECT_LT(outside_workspace(robot, q), 0.0) << "a robot without one may go anywhere";
  EXPECT_EQ(describe_outside_workspace(robot, q, 0.0), "");

  const Pose T_W_R =
      make_pose({0.5, -0.2, 0.1}, Eigen::Quaterniond(Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ())));
  const Pose T_F_T = make_pose({0.01, 0.02, 0.264});
  const Eigen::Vector3d p = (T_W_R * forward(robot, q) * T_F_T).translation();
  const Eigen::Vector3d half(0.1, 0.2, 0.05);
  robot.workspace = ToolWorkspace{{p - half, p + half}, T_W_R, T_F_T};
  EXPECT_NEAR(outside_workspace(robot, q), -0.05, 1e-9);
  robot.workspace->box.translate(Eigen::Vector3d(0.13, 0, 0));
  EXPECT_NEAR(outside_workspace(robot, q), 0.03, 1e-9);
  EXPECT_EQ(describe_outside_workspace(robot, q, 0.031), "");
  EXPECT_THAT(describe_outside_workspace(robot, q, 0.029), testing::HasSubstr("leaves the workspace"));
}

TEST(ToolWorkspace, JointsThatAreNoNumbersAreInsideOfNothing) {
  RobotModel robot = read_robot("ur10");
  robot.workspace = ToolWorkspace{
      {Eigen::Vector3d(-1, -1, -1), Eigen::Vector3d(1, 1, 1)}, Pose::Identity(), Pose::Identity()};
  const Joints nowhere = Joints::Constant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_NE(describe_outside_workspace(robot, nowhere, 0.0), "");
}

}  // namespace
}  // namespace stonestack::kinematics
