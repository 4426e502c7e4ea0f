#include "stacking/wrist.hpp"

#include <gtest/gtest.h>

#include "core/constants.hpp"
#include "stacking/scripted_cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::stacking {
namespace {

const GripperMass kGripper{2.3, {0.01, -0.02, 0.12}};

/// Carries the gripper and perhaps a stone, as the arm stands.
struct LoadedSensor : ForceTorqueSensor {
  const RobotModel& robot;
  const scripted::ScriptedArm& arm;
  CellLayout layout;
  double stone = 0.0;
  Eigen::Vector3d p_F_stone{0.02, 0.01, 0.26};
  Wrench zero_reading;

  LoadedSensor(const RobotModel& r, const scripted::ScriptedArm& a) : robot(r), arm(a) {}
  [[nodiscard]] Wrench raw() const {
    const Eigen::Vector3d n_F_down = -(layout.T_W_R * forward(robot, arm.q)).linear().row(2).transpose();
    const Eigen::Vector3d f_gripper = kGravity * kGripper.mass * n_F_down,
                          f_stone = kGravity * stone * n_F_down;
    return {f_gripper + f_stone + Eigen::Vector3d(1, 2, 3),
            kGripper.p_F_gripper.cross(f_gripper) + p_F_stone.cross(f_stone)};
  }
  Wrench read() override {
    Wrench wrench = raw();
    wrench.force -= zero_reading.force;
    wrench.torque -= zero_reading.torque;
    return wrench;
  }
  void zero() override { zero_reading = raw(); }
};

TEST(Wrist, WeighsTheStoneInAGripperTiltedSinceItsTare) {
  const RobotModel robot = read_robot("ur10");
  scripted::ScriptedArm arm;
  scripted::ScriptedGripper gripper(&arm.commands);
  LoadedSensor sensor(robot, arm);
  scripted::NoCamera camera;
  const auto clock = make_steady_clock();
  Cell cell{arm, gripper, sensor, camera, *clock, sensor.layout};
  Wrist wrist(cell, robot, kGripper);
  wrist.zero();
  for (const double tilt : {0.0, 0.3, -0.5}) {
    arm.q[4] = home_joints()[4] + tilt;
    sensor.stone = 0.0;
    EXPECT_NEAR(wrist.feel().weight, 0.0, 1e-9) << tilt;
    sensor.stone = 0.8;
    const WristLoad load = wrist.feel();
    EXPECT_NEAR(load.weight, kGravity * 0.8, 1e-9) << tilt;
    EXPECT_LT((load.p_F_pull - sensor.p_F_stone).cross(load.n_F_down).norm(), 1e-9) << tilt;
  }
}

}  // namespace
}  // namespace stonestack::stacking
