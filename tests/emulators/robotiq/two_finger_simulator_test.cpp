#include "emulators/robotiq/two_finger_simulator.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <modbus/modbus.h>

#include <array>
#include <thread>

#include "hardware/robotiq/two_finger_gripper.hpp"
#include "kinematics/gripper_file.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kTwoFingerLong = 10.0;  // s

GripperSimulatorOptions quick_gripper() {
  GripperSimulatorOptions options;
  options.port = 0;
  options.rtu = true;
  options.speed_up = 50.0;
  return options;
}

IdealGripperOptions counts_of(const GripperFile& file) {
  return {file.open_count, file.closed_count, 137.0, 0.15};
}

/// A simulated 2F-85 and the driver's options, by link.
class TwoFingers : public testing::TestWithParam<std::string> {
 protected:
  GripperFile file_ = read_gripper_file("robotiq-2f-85");
  IdealGripperPlant plant_{counts_of(file_)};
  TwoFingerSimulator simulator_{plant_, file_, quick_gripper()};

  [[nodiscard]] TwoFingerOptions options() const {
    TwoFingerOptions o;
    o.link = GetParam();
    o.modbus.port = simulator_.endpoint().port;
    o.modbus.device = simulator_.serial_path();
    o.modbus.unit = -1;
    o.modbus.reply_timeout = 1.0;
    o.modbus.quiet = 0.005;
    o.poll = 0.002;
    return o;
  }
  /// Something stands between the fingers.
  void put_between(double opening) {
    const double count =
        file_.closed_count - opening / file_.max_opening * (file_.closed_count - file_.open_count);
    plant_.set_obstacles({count, count, count, 256.0});
  }
};
INSTANTIATE_TEST_SUITE_P(Links, TwoFingers, testing::Values("urcap", "rtu"));

TEST_P(TwoFingers, AreNotActivatedByConnecting) {
  TwoFingerGripper gripper(options());
  EXPECT_FALSE(gripper.is_active());
  EXPECT_THAT(gripper.state().fault, HasSubstr("not activated"));
  EXPECT_THAT([&] { (void)gripper.move(0.05, 0.1, 50.0); },
              ThrowsMessage<DeviceError>(AllOf(HasSubstr("Robotiq gripper"), HasSubstr("not activated"))));
}

TEST_P(TwoFingers, OpenAndCloseToTheMillimetre) {
  TwoFingerGripper gripper(options());
  gripper.activate();
  EXPECT_TRUE(gripper.is_active());
  for (const double opening : {0.085, 0.060, 0.020, 0.0}) {
    const GripperState state = gripper.move(opening, 0.1, 50.0);
    EXPECT_NEAR(state.opening, opening, 0.0003);
    EXPECT_FALSE(state.object);
    EXPECT_FALSE(state.moving);
  }
  EXPECT_THROW((void)gripper.move(0.09, 0.1, 50.0), InvalidArgument);
  EXPECT_NO_THROW(gripper.spread(0.0));
  EXPECT_THROW(gripper.spread(0.04), InvalidArgument);
}

TEST_P(TwoFingers, ReportWhatTheyClosedOn) {
  {
    TwoFingerGripper gripper(options());
    gripper.activate();
    put_between(0.040);
    const GripperState held = gripper.move(0.0, 0.1, 100.0);
    EXPECT_TRUE(held.object);
    EXPECT_NEAR(held.opening, 0.040, 0.0005);
  }
  TwoFingerGripper again(options());  // a program that was started anew
  EXPECT_TRUE(again.state().object) << "the stone is still there";
  put_between(-1.0);
  EXPECT_FALSE(again.move(0.0, 0.05, 100.0).object);
}

TEST_P(TwoFingers, ARequestThatGetsLostIsRepeated) {
  TwoFingerOptions o = options();
  o.echo_timeout = 0.1;
  TwoFingerGripper gripper(o);
  gripper.activate();
  GripperFaults faults;
  faults.ignored_writes = 1;
  simulator_.set_faults(faults);
  EXPECT_NEAR(gripper.move(0.03, 0.1, 50.0).opening, 0.03, 0.0003);
  faults.ignored_writes = 100;
  simulator_.set_faults(faults);
  EXPECT_THAT([&] { (void)gripper.move(0.06, 0.1, 50.0); },
              ThrowsMessage<DeviceError>(HasSubstr("does not echo it")));
}

TEST_P(TwoFingers, NameTheirFaults) {
  TwoFingerGripper gripper(options());
  gripper.activate();
  GripperFaults faults;
  faults.fault = 8;
  simulator_.set_faults(faults);
  EXPECT_THAT(gripper.state().fault, HasSubstr("0x08: too hot"));
  faults.fault = 14;
  simulator_.set_faults(faults);
  EXPECT_THAT([&] { (void)gripper.move(0.03, 0.1, 50.0); },
              ThrowsMessage<DeviceError>(HasSubstr("0x0E: the motor drew too much current")));
  EXPECT_FALSE(gripper.is_active());
  gripper.activate();  // resets
  EXPECT_TRUE(gripper.is_active());
}

TEST_P(TwoFingers, AnActivationThatHangsEnds) {
  TwoFingerOptions o = options();
  o.activation_timeout = 0.2;
  TwoFingerGripper gripper(o);
  GripperFaults faults;
  faults.activation_hangs = true;
  simulator_.set_faults(faults);
  EXPECT_THAT([&] { gripper.activate(); },
              ThrowsMessage<DeviceError>(HasSubstr("the activation did not finish within")));
}

TEST_P(TwoFingers, AMotionThatHangsEnds) {
  TwoFingerOptions o = options();
  o.move_margin = 0.05;
  TwoFingerGripper gripper(o);
  gripper.activate();
  GripperFaults faults;
  faults.stuck_moving = true;
  simulator_.set_faults(faults);
  EXPECT_THAT([&] { (void)gripper.move(0.03, 0.15, 50.0); },
              ThrowsMessage<DeviceError>(HasSubstr("a motion of the fingers did not finish")));
}

TEST_P(TwoFingers, OneBadAnswerIsNotMissed) {
  TwoFingerOptions o = options();
  o.modbus.reply_timeout = 0.3;
  TwoFingerGripper gripper(o);
  gripper.activate();
  (void)gripper.move(0.03, 0.1, 50.0);
  for (const auto fault : {&ModbusFaults::no_reply, &ModbusFaults::truncated, &ModbusFaults::garbage}) {
    ModbusFaults faults;
    faults.*fault = 1;
    simulator_.set_faults(faults);
    EXPECT_NEAR(gripper.state().opening, 0.03, 0.0003);
  }
  ModbusFaults pieces;
  pieces.fragments = true;
  simulator_.set_faults(pieces);
  EXPECT_NEAR(gripper.state().opening, 0.03, 0.0003);
}

TEST_P(TwoFingers, AGripperThatIsGoneIsNoticed) {
  TwoFingerOptions o = options();
  o.modbus.reply_timeout = 0.05;
  TwoFingerGripper gripper(o);
  gripper.activate();
  ModbusFaults silence;
  silence.no_reply = -1;
  simulator_.set_faults(silence);
  EXPECT_THROW((void)gripper.state(), DeviceError);
  simulator_.set_faults(ModbusFaults{});
  EXPECT_EQ(gripper.state().fault, "") << "and found again";
}

class UrCapSocket : public TwoFingers {};
INSTANTIATE_TEST_SUITE_P(Link, UrCapSocket, testing::Values("urcap"));

TEST_P(UrCapSocket, SpeaksTheTextOfTheUrCap) {
  TcpStream stream = TcpStream::connect(simulator_.endpoint(), Deadline::in(kTwoFingerLong));
  const auto ask = [&](const std::string& line, std::size_t length) {
    EXPECT_TRUE(stream.write_all(line, Deadline::in(kTwoFingerLong)));
    std::vector<std::uint8_t> answer(length);
    EXPECT_TRUE(stream.read_exact(answer, Deadline::in(kTwoFingerLong)));
    return std::string(answer.begin(), answer.end());
  };
  EXPECT_EQ(ask("GET ACT\n", 5), "ACT 0");
  EXPECT_EQ(ask("SET ACT 1 GTO 1\n", 3), "ack");
  EXPECT_EQ(ask("GET ACT\n", 5), "ACT 1");
  EXPECT_EQ(ask("SET SPE 255 FOR 0 POS 255\r\n", 3), "ack");
  EXPECT_EQ(ask("GET PRE\n", 7), "PRE 255");
  EXPECT_EQ(ask("GET XYZ\n", 1), "?");
  EXPECT_EQ(ask("SET POS 256\n", 1), "?");
  EXPECT_EQ(ask("open\n", 1), "?");
}

TEST_P(UrCapSocket, ReconnectsAfterTheConnectionDropped) {
  TwoFingerGripper gripper(options());
  gripper.activate();
  (void)gripper.move(0.05, 0.1, 50.0);
  simulator_.drop_clients();
  EXPECT_NEAR(gripper.state().opening, 0.05, 0.0003);
  ModbusFaults faults;
  faults.hang_up = -1;
  simulator_.set_faults(faults);
  EXPECT_THAT(
      [&] { (void)gripper.state(); },
      ThrowsMessage<DeviceError>(AllOf(HasSubstr("127.0.0.1"), HasSubstr("the connection was closed"))));
}

TEST_P(UrCapSocket, ALateAnswerIsNotTakenForTheNext) {
  TwoFingerOptions o = options();
  o.modbus.reply_timeout = 0.1;
  TwoFingerGripper gripper(o);
  gripper.activate();
  (void)gripper.move(0.05, 0.1, 50.0);
  ModbusFaults faults;
  faults.delayed = 1;
  faults.delay = 0.2;
  simulator_.set_faults(faults);
  EXPECT_NEAR(gripper.state().opening, 0.05, 0.0003);
  faults = {};
  faults.wrong_transaction = 1;  // the answer to another question
  simulator_.set_faults(faults);
  EXPECT_NEAR(gripper.state().opening, 0.05, 0.0003);
}

TEST_P(UrCapSocket, RefusesWhatIsNoAnswer) {
  TwoFingerGripper gripper(options());
  ModbusFaults faults;
  faults.exceptions = -1;
  simulator_.set_faults(faults);
  EXPECT_THAT(
      [&] { (void)gripper.state(); },
      ThrowsMessage<DeviceError>(AllOf(HasSubstr("answers 'GET ACT' with '?'"), HasSubstr("pendant"))));
  faults = {};
  faults.garbage = -1;
  simulator_.set_faults(faults);
  EXPECT_THAT([&] { (void)gripper.state(); }, ThrowsMessage<DeviceError>(HasSubstr("63352")));
}

TEST_P(UrCapSocket, AClosedPortIsADeviceError) {
  TwoFingerOptions o = options();
  {
    TcpListener taken({"127.0.0.1", 0});
    o.modbus.port = taken.endpoint().port;
  }
  EXPECT_THAT([&] { TwoFingerGripper gripper(o); },
              ThrowsMessage<DeviceError>(AllOf(HasSubstr("(URCap)"), HasSubstr("URCap is installed"))));
}

/// A foreign master, with the frames of the manual.
TEST(TwoFingerSimulator, IsDrivenByLibmodbus) {
  const GripperFile file = read_gripper_file("robotiq-hand-e");
  IdealGripperPlant plant(counts_of(file));
  const TwoFingerSimulator simulator(plant, file, quick_gripper());
  modbus_t* master = modbus_new_rtu(simulator.serial_path().c_str(), 115200, 'N', 8, 1);
  ASSERT_NE(master, nullptr);
  modbus_set_slave(master, 9);
  modbus_set_response_timeout(master, 5, 0);
  ASSERT_EQ(modbus_connect(master), 0);
  std::array<std::uint16_t, 3> words{};
  const auto wait_for = [&](unsigned mask, unsigned value) {
    for (const Deadline limit = Deadline::in(kTwoFingerLong); !limit.over();) {
      EXPECT_EQ(modbus_read_registers(master, 0x07D0, 3, words.data()), 3) << modbus_strerror(errno);
      if ((words[0] >> 8U & mask) == value) return true;
    }
    return false;
  };
  std::array<std::uint16_t, 3> request{0x0100, 0, 0};
  EXPECT_EQ(modbus_write_registers(master, 0x03E8, 3, request.data()), 3);
  EXPECT_TRUE(wait_for(0x31, 0x31)) << "active";
  request = {0x0900, 0x00FF, 0xFFFF};
  EXPECT_EQ(modbus_write_registers(master, 0x03E8, 3, request.data()), 3);
  EXPECT_TRUE(wait_for(0xF9, 0xF9)) << "closed on nothing";
  EXPECT_EQ(words[1], 0x00FF) << "no fault, the request repeated";
  EXPECT_EQ(words[2] >> 8U, 230U) << "where the pads meet";
  modbus_close(master);
  modbus_free(master);
}

}  // namespace
}  // namespace stonestack::emulators
