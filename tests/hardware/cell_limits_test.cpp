#include "stonestack/hardware/cell_file.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <numbers>

#include "core/constants.hpp"
#include "hardware/cell_config.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/motion/pick_and_place.hpp"
#include "temporary_folder.hpp"

namespace stonestack::hardware {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class CellLimitsFile : public testing::Test {
 protected:
  [[nodiscard]] RobotModel read(const std::string& limits) const {
    write_file(path_,
               "robot: ur10\nlayout: {T_W_R: {x: 0.1, y: 0, z: 0, qx: 0, qy: 0, qz: 0, qw: 1}}\n" + limits);
    return read_cell_robot(read_cell_file(path_));
  }
  [[nodiscard]] std::string problem_of(const std::string& limits) const {
    try {
      static_cast<void>(read(limits));
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  }
  void TearDown() override { std::filesystem::remove(path_); }

  std::string path_ = test::temporary_folder() + "cell_limits_" +
                      testing::UnitTest::GetInstance()->current_test_info()->name() + ".yaml";
};

TEST_F(CellLimitsFile, NarrowWhatTheRobotCan) {
  const RobotModel whole = read_robot("ur10");
  const RobotModel robot = read(
      "limits:\n"
      "  joints: [[-90, 90], [-180, 0], [-150, 150], [-360, 360], [-180, 180], [-270, 270.5]]   # degrees\n"
      "  joint_speed: 0.5\n"
      "  joint_acceleration: 0.25\n"
      "  tool_speed: 0.4   # m/s\n"
      "  workspace: {x: [0.2, 1.0], z: [0, 1.1]}\n"
      "  fence: {x: [-0.3, 1.2]}\n");
  EXPECT_NEAR(robot.lower[0], -90 * kDegree, 1e-9);
  EXPECT_NEAR(robot.upper[1], 0.0, 1e-9);
  EXPECT_NEAR(robot.upper[5], 270.5 * kDegree, 1e-9);
  EXPECT_EQ(robot.lower[3], whole.lower[3]) << "a whole turn is what the robot has";
  EXPECT_TRUE(robot.velocity.isApprox(0.5 * whole.velocity));
  EXPECT_TRUE(robot.acceleration.isApprox(0.25 * whole.acceleration));
  ASSERT_TRUE(robot.workspace);
  EXPECT_EQ(robot.workspace->box.min().x(), 0.2);
  EXPECT_EQ(robot.workspace->box.max().z(), 1.1);
  EXPECT_LT(robot.workspace->box.min().y(), -5.0) << "unbounded in that direction";
  EXPECT_EQ(robot.workspace->T_W_R.translation().x(), 0.1);
  EXPECT_EQ(robot.tool_speed, 0.4);
  ASSERT_TRUE(robot.fence);
  EXPECT_EQ(robot.fence->box.min().x(), -0.3);
  EXPECT_EQ(robot.fence->box.max().x(), 1.2);
  EXPECT_GT(robot.fence->box.max().z(), 5.0);
  EXPECT_EQ(robot.fence->T_W_R.translation().x(), 0.1);
  EXPECT_FALSE(robot.fence->p_F_mounted.empty());
}

TEST_F(CellLimitsFile, LeaveTheRobotWhereNothingIsWritten) {
  const RobotModel whole = read_robot("ur10"), robot = read("");
  EXPECT_EQ(robot.lower, whole.lower);
  EXPECT_EQ(robot.velocity, whole.velocity);
  EXPECT_FALSE(robot.workspace);
  EXPECT_FALSE(robot.fence);
  EXPECT_EQ(robot.tool_speed, motion::MotionOptions().tool_speed) << "or plans would be slower than asked";
}

TEST_F(CellLimitsFile, AreRefusedWhereTheyMakeNoSense) {
  const auto joints = [&](const std::string& first) {
    return problem_of("limits: {joints: [" + first + ", [-9, 9], [-9, 9], [-9, 9], [-9, 9], [-9, 9]]}\n");
  };
  EXPECT_EQ(joints("[-9, 9]"), "");
  EXPECT_THAT(joints("[90, -90]"), AllOf(HasSubstr(path_), HasSubstr("limits.joints[0] is [90, -90]")));
  EXPECT_THAT(joints("[5, 5]"), HasSubstr("leaves nothing"));
  EXPECT_THAT(joints("[-400, 90]"), HasSubstr("wider than the robot's own, -360 to 360 deg"));
  EXPECT_THAT(joints("[-.inf, 90]"), HasSubstr("limits.joints[0][0] is not a finite number"));
  EXPECT_THAT(joints("[-9, .nan]"), HasSubstr("limits.joints[0][1] is not a finite number"));
  EXPECT_THAT(joints("[-9, nine]"), HasSubstr("not a finite number"));
  EXPECT_THAT(joints("[-9]"), HasSubstr("not a pair of numbers"));
  EXPECT_THAT(joints("-9"), HasSubstr("not a pair of numbers"));
  EXPECT_THAT(problem_of("limits: {joints: [[-9, 9]]}\n"), HasSubstr("six"));
  EXPECT_THAT(problem_of("limits: {joints: 90}\n"), HasSubstr("six"));
  EXPECT_THAT(problem_of("limits: {workspace: {z: [1, 0]}}\n"), HasSubstr("limits.workspace.z is [1, 0]"));
  EXPECT_THAT(problem_of("limits: {workspace: {z: [0, 1100]}}\n"), HasSubstr("metres"));
  EXPECT_THAT(problem_of("limits: {workspace: {y: 1}}\n"), HasSubstr("not a pair"));
  EXPECT_THAT(problem_of("limits: {workspace: {w: [0, 1]}}\n"), HasSubstr("limits.workspace.w"));
  EXPECT_THAT(problem_of("limits: {fence: {x: [0.2, 1.1]}}\n"),
              AllOf(HasSubstr(path_), HasSubstr("limits.fence.x is [0.2, 1.1] m"),
                    HasSubstr("base stands outside, at 0.1 m"), HasSubstr("limits.workspace")));
  EXPECT_THAT(problem_of("limits: {fence: {y: [1, -1]}}\n"), HasSubstr("limits.fence.y is [1, -1]"));
  EXPECT_THAT(problem_of("limits: {tool_speed: 0}\n"), HasSubstr("limits.tool_speed"));
  EXPECT_THAT(problem_of("limits: {tool_speed: .nan}\n"), HasSubstr("limits.tool_speed"));
  EXPECT_THAT(problem_of("limits: {joint_speed: 1.5}\n"), HasSubstr("joint_speed"));
  EXPECT_THAT(problem_of("limits: {joint_speed: 0}\n"), HasSubstr("joint_speed"));
  EXPECT_THAT(problem_of("limits: {joint_acceleration: .nan}\n"), HasSubstr("joint_acceleration"));
}

}  // namespace
}  // namespace stonestack::hardware
