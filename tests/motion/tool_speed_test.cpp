#include "motion/path/tool_speed.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "motion/timing.hpp"
#include "motion/transit.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

using hardware::CellLayout;

constexpr double kAbove = 0.08;  // m, between tower and tool as it passes

Joints turned(double base) {
  Joints q;
  q << base, -1.9, 1.9, -1.57, -1.57, 0.0;
  return q;
}

/// A tower under the path of the gripper from turned(-0.9) to turned(0.9).
struct Passing {
  PlanningScene scene;
  Eigen::AlignedBox3d tower;

  Passing() {
    scene.robot = read_robot("ur10");
    scene.T_F_T = CellLayout().T_F_T;
    const Eigen::Vector3d p = (forward(scene.robot, turned(0.0)) * scene.T_F_T).translation();
    const Eigen::Vector3d size(0.12, 0.12, p.z() - kAbove), centre(p.x(), p.y(), size.z() / 2);
    scene.objects = {{"tower", {make_box(size)}, make_pose(centre)}};
    tower = {centre - size / 2, centre + size / 2};
  }
  /// Largest speeds (m/s) of the tool's tip nearer to the tower than `near` and elsewhere.
  [[nodiscard]] std::pair<double, double> speeds(const JointTrajectory& motion, double near) const {
    constexpr double kStep = 0.001;
    std::pair<double, double> fastest{0.0, 0.0};
    const auto tool = [&](double t) {
      return (forward(scene.robot, sample(motion, t).q) * scene.T_F_T).translation().eval();
    };
    for (double t = kStep; t < motion.duration(); t += kStep) {
      const double v = (tool(t) - tool(t - kStep)).norm() / kStep;
      double& max = tower.exteriorDistance(tool(t)) < near ? fastest.first : fastest.second;
      max = std::max(max, v);
    }
    return fastest;
  }
};

TEST(ToolSpeed, TransitsAreSlowNearObjectsAndBoundedElsewhere) {
  const Passing passing;
  for (const double jerk : {0.0, 10.0}) {
    MotionOptions options;
    options.jerk = jerk;
    options.speed_scale = 1.0;
    options.tool_speed = 0.5;
    options.near_speed = 0.15;
    options.near_distance = 0.15;
    const auto motion = plan_transit(passing.scene, turned(-0.9), turned(0.9), options);
    ASSERT_TRUE(motion.has_value());
    const auto [near, open] = passing.speeds(*motion, options.near_distance);
    EXPECT_GT(near, 0.0) << "or the gripper did not pass the tower";
    EXPECT_LE(near, 0.1502);
    EXPECT_LE(open, 0.5005);
    EXPECT_GT(open, 0.3);
  }
}

// The cell's limit holds for every motion, whatever the options ask for.
TEST(ToolSpeed, NoMotionIsFasterThanTheRobotMay) {
  Passing passing;
  passing.scene.objects.clear();
  passing.scene.robot.tool_speed = 0.25;
  for (const double jerk : {0.0, 10.0}) {
    MotionOptions options;
    options.jerk = jerk;
    options.speed_scale = 1.0;
    const auto motion = plan_transit(passing.scene, turned(-0.9), turned(0.9), options);
    ASSERT_TRUE(motion.has_value());
    const auto expect_used = [&](const JointTrajectory& timed, double max) {
      const double fastest = passing.speeds(timed, 0.0).second;
      EXPECT_LE(fastest, 1.001 * max);
      EXPECT_GT(fastest, 0.8 * max) << "slower than it need be";
    };
    expect_used(*motion, 0.25);
    TimingLimits limits = timing_limits(passing.scene.robot, options);
    for (const double asked : {0.0, 0.1, 0.5}) {
      limits.tool_speed = asked;
      expect_used(time_path({turned(-0.2), turned(0.2)}, limits, passing.scene.robot, passing.scene.T_F_T),
                  asked == 0.1 ? 0.1 : 0.25);
    }
  }
}

TEST(ToolSpeed, AHeldStoneExtendsTheToolAndIsNoObstacle) {
  const PlanningScene scene = Passing().scene;
  MotionOptions options;
  options.near_distance = kAbove - 0.05;
  EXPECT_EQ(transit_speed(scene, options)(turned(0.0)), options.tool_speed);
  EXPECT_EQ(transit_speed(scene, options, -1, 0.06)(turned(0.0)), options.near_speed);
  options.near_distance = kAbove;
  EXPECT_EQ(transit_speed(scene, options)(turned(0.0)), options.near_speed);
  EXPECT_EQ(transit_speed(scene, options, 0)(turned(0.0)), options.tool_speed) << "it is in the gripper";
}

}  // namespace
}  // namespace stonestack::motion
