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

/// A connection to the text socket that sends pieces of lines.
class TextPieces {
 public:
  explicit TextPieces(const Endpoint& server)
      : stream_(TcpStream::connect(server, Deadline::in(kTwoFingerLong))) {}
  std::string ask(const std::string& text, std::size_t length) {
    EXPECT_TRUE(stream_.write_all(text, Deadline::in(kTwoFingerLong)));
    std::vector<std::uint8_t> answer(length);
    const IoResult got = stream_.read_exact(answer, Deadline::in(patience_));
    if (!got) patience_ = 0.1;  // no answer is a failure, and need not be a long one for each request
    return {answer.begin(), answer.begin() + static_cast<std::ptrdiff_t>(got.bytes)};
  }
  bool is_silent_after(const std::string& text) {
    EXPECT_TRUE(stream_.write_all(text, Deadline::in(kTwoFingerLong)));
    std::array<std::uint8_t, 16> answer{};
    return stream_.read_some(answer, Deadline::in(0.1)).status == IoStatus::kTimeOut;
  }

 private:
  TcpStream stream_;
  double patience_ = kTwoFingerLong;
};

TEST_P(UrCapSocket, AnswersARequestWithoutALineEndByTheBareValue) {
  TextPieces client(simulator_.endpoint());
  EXPECT_EQ(client.ask("GET STA", 1), "0");
  EXPECT_TRUE(client.is_silent_after("\n")) << "a line end that comes late";
  EXPECT_EQ(client.ask("GET OBJ", 1), "0");
  EXPECT_EQ(client.ask("GET GTO", 1), "0");
  EXPECT_EQ(client.ask("GET FLT", 2), "00");
  EXPECT_EQ(client.ask("SET SPE 7 FOR 8 POS 9\n", 3), "ack");
  EXPECT_EQ(client.ask("GET PRE", 3), "009");
  EXPECT_EQ(client.ask("GET PRE\n", 5), "PRE 9") << "with its end it is answered in full";
  EXPECT_EQ(client.ask("GET POSE", 1), "?");
  std::string many;
  for (int i = 0; i < 40; ++i) many += "GET FOR\n";
  std::string answers;
  for (int i = 0; i < 40; ++i) answers += "FOR 8";
  EXPECT_EQ(client.ask(many, answers.size()), answers) << "lines that come together";
}

TEST_P(UrCapSocket, WaitsForTheEndOfALineThatSets) {
  TextPieces client(simulator_.endpoint());
  for (const std::string piece : {"SET POS", " ", "120", " ", "SPE", " ", "255"})
    EXPECT_TRUE(client.is_silent_after(piece)) << piece;
  EXPECT_EQ(client.ask(" FOR 1\n", 3), "ack");
  EXPECT_EQ(client.ask("GET PRE\n", 7), "PRE 120");
}

TEST_P(UrCapSocket, KeepsTheVariablesThatRobotiqsScriptSets) {
  TextPieces client(simulator_.endpoint());
  EXPECT_EQ(client.ask("GET MSC\n", 5), "MSC 0");
  for (const std::string name : {"MOD", "MSC", "LBP", "LRD", "LBL", "LGN", "SCN_BLOCK"}) {
    EXPECT_EQ(client.ask("SET " + name + " 50\n", 3), "ack") << name;
    EXPECT_EQ(client.ask("GET " + name + "\n", name.size() + 3), name + " 50");
  }
  EXPECT_EQ(client.ask("GET MSC", 2), "50");
  EXPECT_EQ(client.ask("SET ARD 1\n", 3), "ack");
  EXPECT_EQ(client.ask("GET ARD\n", 5), "ARD 1");
  EXPECT_EQ(client.ask("GET ATR\n", 5), "ATR 0");
  EXPECT_EQ(client.ask("GET COU\n", 5), "COU 0");
  EXPECT_EQ(client.ask("GET NCY", 1), "0");
  EXPECT_EQ(client.ask("GET PCO", 1), "0");
  EXPECT_EQ(client.ask("GET DST", 1), "3") << "not active";
  for (const std::string name : {"SNU", "FWV", "VER"})
    EXPECT_EQ(client.ask("GET " + name, 9), "simulated") << name;
}

TEST_P(UrCapSocket, AcknowledgesItsOwnIdOnly) {
  TextPieces client(simulator_.endpoint());
  EXPECT_EQ(client.ask("GET SID", 3), "[9]");
  EXPECT_EQ(client.ask("SET SID 9\n", 3), "ack");
  EXPECT_EQ(client.ask("SET SID 5\n", 1), "?") << "no such gripper is connected";
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

/// A foreign master on the serial line of a 2F-85.
class TwoFingerMaster : public testing::Test {
 protected:
  TwoFingerMaster() {
    modbus_set_slave(master_, 9);
    modbus_set_response_timeout(master_, 5, 0);
    EXPECT_EQ(modbus_connect(master_), 0);
  }
  ~TwoFingerMaster() override {
    modbus_close(master_);
    modbus_free(master_);
  }
  GripperFile file_ = read_gripper_file("robotiq-2f-85");
  IdealGripperPlant plant_{counts_of(file_)};
  TwoFingerSimulator simulator_{plant_, file_, quick_gripper()};
  modbus_t* master_ = modbus_new_rtu(simulator_.serial_path().c_str(), 115200, 'N', 8, 1);
};

TEST_F(TwoFingerMaster, ReadsMoreStatusRegistersThanHaveAMeaning) {
  std::array<std::uint16_t, 9> words{};
  for (const int count : {6, 8}) {  // the driver of Robotiq's ROS 2 package reads six
    words.fill(0xFFFF);
    ASSERT_EQ(modbus_read_registers(master_, 0x07D0, count, words.data()), count) << modbus_strerror(errno);
    for (std::size_t i = 3; i < static_cast<std::size_t>(count); ++i) EXPECT_EQ(words[i], 0U) << i;
  }
  modbus_set_response_timeout(master_, 0, 100000);
  EXPECT_EQ(modbus_read_registers(master_, 0x07D0, 9, words.data()), -1);
  EXPECT_EQ(modbus_read_registers(master_, 0x03E8, 4, words.data()), -1) << "commands are three";
}

TEST_F(TwoFingerMaster, WritesBeforeItReadsInOneRequest) {
  std::array<std::uint16_t, 3> request{0x0100, 0x0037, 0xFFFF}, words{};
  ASSERT_EQ(modbus_write_and_read_registers(master_, 0x03E8, 3, request.data(), 0x07D0, 3, words.data()), 3)
      << modbus_strerror(errno);
  EXPECT_EQ(words[0] >> 8U & 0x01U, 1U);
  EXPECT_EQ(words[1], 0x0037U) << "the request is echoed";
  modbus_set_response_timeout(master_, 0, 100000);
  request[0] = 0x00E6;
  EXPECT_EQ(modbus_write_and_read_registers(master_, 0x03E9, 1, request.data(), 4000, 1, words.data()), -1);
  modbus_set_response_timeout(master_, 5, 0);
  ASSERT_EQ(modbus_read_registers(master_, 0x03E8, 3, words.data()), 3);
  EXPECT_EQ(words[1], 0x0037U) << "a request that is refused writes nothing";
}

TEST_F(TwoFingerMaster, GetsTheManualsReplyToAReadAndAWriteInOne) {
  // The manual's gripper has fault 9 and is not active, as one is that releases.
  GripperFaults faults;
  faults.fault = 9;
  simulator_.set_faults(faults);
  ASSERT_EQ(modbus_write_register(master_, 0x03E8, 0x0100), 1);
  ASSERT_EQ(modbus_write_register(master_, 0x03E8, 0x1100), 1);
  const std::array<std::uint8_t, 15> request{0x09, 0x17, 0x07, 0xD0, 0x00, 0x02, 0x03, 0xE9,
                                             0x00, 0x02, 0x04, 0x00, 0xE6, 0x3C, 0xC8};
  ASSERT_EQ(modbus_send_raw_request(master_, request.data(), static_cast<int>(request.size())), 17);
  std::array<std::uint8_t, MODBUS_RTU_MAX_ADU_LENGTH> reply{};
  ASSERT_EQ(modbus_receive_confirmation(master_, reply.data()), 9);
  const std::array<std::uint8_t, 9> expected{0x09, 0x17, 0x04, 0x01, 0x00, 0x09, 0xE6, 0xF6, 0xC1};
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), reply.begin()));
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
