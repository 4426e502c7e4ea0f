#include "stacking/gripper_motion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "stacking/scripted_cell.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::stacking {
namespace {

/// Gripper whose next motions fail, as it does with a fault that passes.
struct Failing : scripted::Bench {
  int failures = 1;
  int moves = 0;

  Failing() {
    gripper.after_move = [this](double) {
      ++moves;
      if (failures-- > 0) throw DeviceError("gripper", "minor fault", "look at the gripper");
    };
  }
  void open() { (void)move_gripper(cell, nullptr, 0.1, 0.05, 60.0); }
};

TEST(GripperMotion, AFaultThatPassesGetsTheCommandOnceMore) {
  const std::string path = stonestack::test::temporary_folder() + "gripper_motion.jsonl";
  std::filesystem::remove(path);
  Failing bench;
  Journal journal(path);
  (void)move_gripper(bench.cell, &journal, 0.1, 0.05, 60.0);
  EXPECT_EQ(bench.moves, 2);
  const std::string lines = read_file(path, 1 << 16);
  EXPECT_THAT(lines, testing::HasSubstr("gripper_retried"));
  EXPECT_THAT(lines, testing::HasSubstr("minor fault"));
  std::filesystem::remove(path);
}

TEST(GripperMotion, ASecondFaultEndsIt) {
  Failing bench;
  bench.failures = 2;
  EXPECT_THROW(bench.open(), DeviceError);
  EXPECT_EQ(bench.moves, 2);
}

TEST(GripperMotion, NoCommandIsRepeatedWhileTheFaultLastsOrTheFingersMove) {
  Failing faulty;
  faulty.gripper.fault = "major fault";
  EXPECT_THROW(faulty.open(), DeviceError);
  EXPECT_EQ(faulty.moves, 1);

  Failing stuck;
  stuck.gripper.moving = 5;
  EXPECT_THROW(stuck.open(), DeviceError);
  EXPECT_EQ(stuck.moves, 1);
}

TEST(GripperMotion, NoCommandIsRepeatedOnceTheArmHasStopped) {
  Failing bench;
  bench.arm.can_move = false;
  EXPECT_THROW(bench.open(), DeviceError);
  EXPECT_EQ(bench.moves, 1);
}

}  // namespace
}  // namespace stonestack::stacking
