#include "simulation/shared_world.hpp"

#include <gtest/gtest.h>

#include <atomic>

#include "pebble.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::simulation {
namespace {

struct SharedBench {
  std::vector<Stone> stones{make_pebble("pebble", 1.2)};
  RobotModel robot = read_robot("ur10");
  CellLayout layout;
  SimulatedCell cell{stones, {0_stone}, robot, layout};
  SharedWorld& world = cell.shared();
  Joints q = cell.cell().arm.state().q;
};

TEST(SharedWorld, ArmAndFingersMoveInOneStretchOfTime) {
  SharedBench bench;
  const double start = bench.world.time();
  const GripperPose before = bench.world.lock().world.gripper_pose();
  int ticks = 0;
  bench.world.drive_fingers([&](const TrueWorld& world, double seconds) {
    ++ticks;
    auto finger = world.gripper_pose().finger;
    for (auto& place : finger) place -= 0.02 * seconds;
    return FingerPlaces{finger, 0.010};
  });
  Pose goal = before.T_W_T;
  goal.translation().z() += 0.001;
  EXPECT_TRUE(bench.world.move_arm(goal, 0.008).stopped.empty());
  EXPECT_EQ(ticks, 4) << "the fingers' control runs every 2 ms";
  const GripperPose after = bench.world.lock().world.gripper_pose();
  EXPECT_NEAR(after.T_W_T.translation().z(), goal.translation().z(), 1e-12);
  EXPECT_NEAR(after.finger[0], before.finger[0] - 0.02 * 0.008, 1e-12);
  EXPECT_NEAR(after.narrowed, 0.010, 1e-12);
  EXPECT_NEAR(bench.world.time(), start + 0.008, 1e-12);
}

TEST(SharedWorld, OthersWaitForSimulatedTime) {
  SharedBench bench;
  const double start = bench.world.time();
  EXPECT_FALSE(bench.world.wait_until(start + 0.1, 0.01)) << "nobody lets time pass";
  std::atomic<bool> arrived = false;
  std::thread other([&] { arrived = bench.world.wait_until(start + 0.1, 30.0); });
  for (int k = 0; k < 60; ++k) bench.world.pass(0.002);
  other.join();
  EXPECT_TRUE(arrived);
  bench.world.start(50.0);
  EXPECT_TRUE(bench.world.wait_until(start + 0.5, 30.0)) << "the loop lets time pass by itself";
  bench.world.stop();
  const double end = bench.world.time();
  EXPECT_FALSE(bench.world.wait_until(end + 0.01, 0.05));
}

TEST(SharedWorld, AnErrorOfTheFingersControlStopsTimeAndNotTheProcess) {
  SharedBench bench;
  const double start = bench.world.time();
  bench.world.drive_fingers(
      [](const TrueWorld&, double) -> FingerPlaces { throw DeviceError("fingers", "broken", "none"); });
  bench.world.start(50.0);
  EXPECT_FALSE(bench.world.wait_until(start + 0.1, 0.5));
  bench.world.stop();
  bench.world.drive_fingers({});
  bench.world.start(50.0);
  EXPECT_TRUE(bench.world.wait_until(start + 0.1, 30.0)) << "it can be started again";
}

}  // namespace
}  // namespace stonestack::simulation
