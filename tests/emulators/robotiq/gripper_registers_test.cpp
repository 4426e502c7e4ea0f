#include "emulators/robotiq/gripper_registers.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "emulators/robotiq/two_finger_registers.hpp"
#include "kinematics/gripper_file.hpp"

namespace stonestack::emulators {
namespace {

using Words = GripperRegisters::Words;

constexpr double kTick = 0.002;  // s

/// A gripper whose time is advanced by the test.
struct RegisterBench {
  IdealGripperPlant plant;
  GripperRegisters registers{plant};

  void write(const std::vector<std::uint16_t>& words) { registers.write(0, words); }
  void pass(double seconds) {
    for (double t = 0; t < seconds; t += kTick) registers.advance(kTick);
  }
  [[nodiscard]] unsigned byte(std::size_t i) const {
    const std::uint16_t word = registers.status()[i / 2];
    return i % 2 == 0 ? word >> 8U : word & 0xFFU;
  }
  void activate() {
    write({0x0100, 0, 0});
    pass(10.0);
  }
};

TEST(GripperRegisters, StartsReset) {
  RegisterBench bench;
  bench.pass(0.1);
  EXPECT_EQ(bench.byte(0), 0x00U);
  EXPECT_EQ(bench.byte(2), 0U);
}

TEST(GripperRegisters, ActivatesOverOpenAndClosedFingers) {
  RegisterBench bench;
  bench.write({0x0100, 0, 0});
  bench.pass(0.01);
  EXPECT_EQ(bench.byte(0), 0x11U) << "the manual's 'not activated' status";
  unsigned widest = 0;
  for (int i = 0; i < 5000 && bench.byte(0) == 0x11U; ++i) {
    bench.pass(kTick);
    widest = std::max(widest, bench.byte(4));
  }
  EXPECT_EQ(bench.byte(0), 0x31U) << "the manual's 'activated' status";
  EXPECT_GT(widest, 200U) << "an activation closes the fingers";
  EXPECT_EQ(bench.byte(4), 6U) << "and opens them";
}

TEST(GripperRegisters, ClosesUponAnObjectAsInTheManual) {
  RegisterBench bench;
  bench.activate();
  bench.plant.set_obstacles({0xBC, 0xC1, 0xBD, 256});
  bench.write({0x0900, 0x00FF, 0xFFFF});
  bench.pass(kTick);
  EXPECT_EQ(bench.byte(0), 0x39U);
  EXPECT_EQ(bench.byte(1), 0xC0U);
  EXPECT_EQ(bench.byte(5), 0x0FU);
  bench.pass(3.0);
  const Words gripped{0xB9EA, 0x00FF, 0xBC00, 0x00C1, 0x0000, 0xBD00, 0x0089, 0x0000};
  EXPECT_EQ(bench.registers.status(), gripped);
}

TEST(GripperRegisters, OpenReportsItsSoftwareLimitNotZero) {
  RegisterBench bench;
  bench.activate();
  bench.write({0x0900, 0x0000, 0xFFFF});
  bench.pass(1.0);
  EXPECT_EQ(bench.byte(0), 0xF9U);
  EXPECT_EQ(bench.byte(1), 0xFFU);
  EXPECT_EQ(bench.byte(3), 0U);
  EXPECT_EQ(bench.byte(4), 6U);
}

TEST(GripperRegisters, OneFingerStoppedEarlyIsReported) {
  RegisterBench bench;
  bench.activate();
  bench.plant.set_obstacles({256, 100, 256, 256});
  bench.write({0x0900, 0x00FF, 0xFFFF});
  bench.pass(3.0);
  EXPECT_EQ(bench.byte(0) >> 6U, 1U);
  EXPECT_EQ(bench.byte(1) & 0x3FU, 0x3BU) << "A and C at request, B in contact";
}

TEST(GripperRegisters, SpeedAndForceFollowTheDataSheet) {
  // 22 mm/s at 0 and 110 mm/s at 255; 155 mm are 255 counts.
  for (const auto& [speed, counts] : {std::pair{0, 36.2}, std::pair{255, 181.0}}) {
    RegisterBench bench;
    bench.activate();
    const unsigned start = bench.byte(4);
    bench.write({0x0900, 0x00FF, static_cast<std::uint16_t>(speed << 8)});
    bench.pass(1.0);
    EXPECT_NEAR(bench.byte(4) - start, counts, 1.5) << speed;
  }
}

TEST(GripperRegisters, IndividualFingersGoWhereEachIsSent) {
  RegisterBench bench;
  bench.activate();
  bench.write({0x090C, 0x0032, 0xFFFF, 0x64FF, 0xFF96, 0xFFFF, 0x50FF, 0xFF00});
  bench.pass(5.0);
  EXPECT_EQ(bench.byte(4), 0x32U);
  EXPECT_EQ(bench.byte(7), 0x64U);
  EXPECT_EQ(bench.byte(10), 0x96U);
  EXPECT_EQ(bench.byte(13), 0x50U);
  EXPECT_EQ(bench.byte(6), 0x64U) << "requests of B are echoed too";
}

TEST(GripperRegisters, ARequestThatWaitedForTheActivationIsNotReportedAsReached) {
  for (const std::uint16_t action : {0x0900, 0x0B00}) {  // basic mode, and pinch mode, which it changes to
    RegisterBench bench;
    bench.write({action, 0x00FF, 0xFFFF});
    int ready = 0;
    for (int i = 0; i < 10000 && ready < 100; ++i) {
      bench.pass(kTick);
      if ((bench.byte(0) & 0x30U) != 0x30U) continue;
      ++ready;
      ASSERT_EQ(bench.byte(0) >> 6U, 0U) << "ticks since it is ready: " << ready;
      ASSERT_EQ(bench.byte(1) & 0x3FU, 0U);
      ASSERT_LT(bench.byte(4), 100U);
    }
    EXPECT_EQ(ready, 100);
    bench.pass(3.0);
    EXPECT_EQ(bench.byte(0) >> 6U, 3U) << "reached in the end";
  }
}

TEST(TwoFingerRegisters, ARequestThatWaitedForTheActivationIsNotReportedAsReached) {
  const GripperFile file = read_gripper_file("robotiq-2f-85");
  IdealGripperPlant plant({file.open_count, file.closed_count, 137.0, 0.15});
  TwoFingerRegisters registers(plant, file);
  registers.write(0, std::vector<std::uint16_t>{0x0900, 0x00FF, 0xFFFF});
  const auto first = [&] { return registers.status()[0] >> 8U; };
  for (int i = 0; i < 10000 && (first() & 0x30U) != 0x30U; ++i) registers.advance(kTick);
  EXPECT_EQ(first(), 0x39U) << "ready and moving";
  EXPECT_EQ(registers.status()[1], 0x00FFU) << "towards the request";
  for (int i = 0; i < 2000; ++i) registers.advance(kTick);
  EXPECT_EQ(first(), 0xF9U);
}

TEST(GripperRegisters, AModeChangeTakesTimeAndPinchClosesLess) {
  RegisterBench bench;
  bench.activate();
  bench.write({0x0300, 0, 0});
  bench.pass(0.1);
  EXPECT_EQ(bench.byte(0), 0x21U) << "mode still basic, changing";
  bench.write({0x0B00, 0x00FF, 0xFFFF});
  EXPECT_EQ(bench.byte(2), 6U) << "the mode change must finish first";
  bench.pass(2.0);
  EXPECT_EQ(bench.byte(0) & 0x37U, 0x33U);
  bench.pass(3.0);
  EXPECT_EQ(bench.byte(0) >> 6U, 3U);
  EXPECT_LT(bench.byte(4), 0xF1U);
}

TEST(GripperRegisters, GoingBeforeTheActivationIsAFault) {
  RegisterBench bench;
  bench.write({0x0800, 0x00FF, 0xFFFF});
  bench.pass(0.1);
  EXPECT_EQ(bench.byte(2), 7U);
  bench.write({0x0900, 0x00FF, 0xFFFF});
  bench.pass(0.1);
  EXPECT_EQ(bench.byte(2), 5U);
}

TEST(GripperRegisters, AnAutomaticReleaseNeedsAReset) {
  RegisterBench bench;
  bench.activate();
  bench.write({0x0900, 0x00FF, 0xFFFF});
  bench.pass(3.0);
  bench.write({0x1100, 0, 0});
  bench.pass(0.1);
  EXPECT_EQ(bench.byte(2), 0xBU);
  bench.pass(10.0);
  EXPECT_EQ(bench.byte(2), 0xFU);
  EXPECT_EQ(bench.byte(4), 6U) << "released";
  bench.write({0x0000, 0, 0});
  bench.activate();
  EXPECT_EQ(bench.byte(0), 0x31U);
  EXPECT_EQ(bench.byte(2), 0U);
}

TEST(GripperRegisters, StopsWhenTheGoBitIsCleared) {
  RegisterBench bench;
  bench.activate();
  bench.write({0x0900, 0x00FF, 0xFFFF});
  bench.pass(0.5);
  bench.write({0x0100, 0x00FF, 0xFFFF});
  bench.pass(0.01);
  const unsigned stopped = bench.byte(4);
  bench.pass(1.0);
  EXPECT_EQ(bench.byte(4), stopped);
  EXPECT_LT(stopped, 0xC0U);
}

}  // namespace
}  // namespace stonestack::emulators
