#include "emulators/robotiq/gripper_simulator.hpp"

#include <gmock/gmock.h>
#include <modbus/modbus.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include "core/serial.hpp"
#include "hardware/robotiq/three_finger_gripper.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

using Bytes = std::vector<std::uint8_t>;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kGripperLong = 10.0;  // s

GripperSimulatorOptions fast(bool rtu) {
  GripperSimulatorOptions options;
  options.port = 0;
  options.rtu = rtu;
  options.speed_up = 50.0;
  return options;
}

ThreeFingerOptions client_options(const GripperSimulator& simulator, const std::string& preset) {
  ThreeFingerOptions options;
  options.preset = preset;
  if (preset == "rtu") {
    options.modbus.device = simulator.serial_path();
  } else {
    options.modbus.port = simulator.endpoint().port;
  }
  options.modbus.reply_timeout = 2.0;
  options.poll = 0.002;
  return options;
}

Bytes exchange(ByteStream& stream, const Bytes& request, std::size_t length) {
  EXPECT_TRUE(stream.write_all(request, Deadline::in(kGripperLong)));
  Bytes reply(length);
  const IoResult got = stream.read_exact(reply, Deadline::in(kGripperLong));
  reply.resize(got.bytes);
  return reply;
}

TEST(GripperSimulator, AnswersTheManualsTcpFramesByteForByte) {
  IdealGripperPlant plant;
  const GripperSimulator simulator(plant, fast(false));
  TcpStream stream = TcpStream::connect(simulator.endpoint(), Deadline::in(kGripperLong));
  const Bytes activate{0x33, 0x9A, 0x00, 0x00, 0x00, 0x0D, 0x02, 0x10, 0x00, 0x00,
                       0x00, 0x03, 0x06, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00};
  EXPECT_EQ(exchange(stream, activate, 12),
            (Bytes{0x33, 0x9A, 0x00, 0x00, 0x00, 0x06, 0x02, 0x10, 0x00, 0x00, 0x00, 0x03}));
  const Bytes status{0x45, 0x33, 0x00, 0x00, 0x00, 0x06, 0x02, 0x04, 0x00, 0x00, 0x00, 0x01};
  const Bytes done{0x45, 0x33, 0x00, 0x00, 0x00, 0x05, 0x02, 0x04, 0x02, 0x31, 0x00};
  const Deadline limit = Deadline::in(kGripperLong);
  Bytes reply;
  while (reply != done && !limit.over()) reply = exchange(stream, status, done.size());
  EXPECT_EQ(reply, done);
}

TEST(GripperSimulator, AnswersTheManualsSerialFramesByteForByte) {
  IdealGripperPlant plant;
  GripperSimulatorOptions options = fast(true);
  options.tcp = false;
  const GripperSimulator simulator(plant, options);
  SerialPort line = SerialPort::open(simulator.serial_path(), 115200);
  const Bytes activate{0x09, 0x10, 0x03, 0xE8, 0x00, 0x03, 0x06, 0x01,
                       0x00, 0x00, 0x00, 0x00, 0x00, 0x72, 0xE1};
  EXPECT_EQ(exchange(line, activate, 8), (Bytes{0x09, 0x10, 0x03, 0xE8, 0x00, 0x03, 0x01, 0x30}));
  const Bytes status{0x09, 0x03, 0x07, 0xD0, 0x00, 0x01, 0x85, 0xCF};
  const Bytes done{0x09, 0x03, 0x02, 0x31, 0x00, 0x4C, 0x15};
  const Deadline limit = Deadline::in(kGripperLong);
  Bytes reply;
  while (reply != done && !limit.over()) reply = exchange(line, status, done.size());
  EXPECT_EQ(reply, done);
  const Bytes close{0x09, 0x10, 0x03, 0xE8, 0x00, 0x03, 0x06, 0x09, 0x00, 0x00, 0xFF, 0xFF, 0xFF, 0x42, 0x29};
  EXPECT_EQ(exchange(line, close, 8), (Bytes{0x09, 0x10, 0x03, 0xE8, 0x00, 0x03, 0x01, 0x30}));
}

TEST(GripperSimulator, KeepsSilentOnTheSerialLineWhereTheGripperDoes) {
  IdealGripperPlant plant;
  const GripperSimulator simulator(plant, fast(true));
  SerialPort line = SerialPort::open(simulator.serial_path(), 115200);
  Bytes got(1);
  for (const Bytes& request : {Bytes{0x02, 0x03, 0x07, 0xD0, 0x00, 0x01, 0x84, 0xB4},     // another unit
                               Bytes{0x09, 0x03, 0x07, 0xD0, 0x00, 0x01, 0x85, 0xCE},     // bad CRC
                               Bytes{0x09, 0x03, 0x00, 0xB4, 0x00, 0x06, 0x84, 0xA6}}) {  // no such registers
    ASSERT_TRUE(line.write_all(request, Deadline::in(kGripperLong)));
    EXPECT_EQ(line.read_some(got, Deadline::in(0.1)).status, IoStatus::kTimeOut);
  }
  const Bytes status{0x09, 0x03, 0x07, 0xD0, 0x00, 0x01, 0x85, 0xCF};
  EXPECT_EQ(exchange(line, status, 7).size(), 7U) << "and answers the next one";
}

/// A cycle by libmodbus: activate, close, see it closed; status by either function and from either base.
void drive_by_libmodbus(modbus_t* master, int commands, int status) {
  std::array<std::uint16_t, 8> words{};
  const auto wait_for = [&](unsigned mask, unsigned value) {
    for (const Deadline limit = Deadline::in(kGripperLong); !limit.over();) {
      EXPECT_EQ(modbus_read_input_registers(master, status, 8, words.data()), 8) << modbus_strerror(errno);
      if ((words[0] >> 8U & mask) == value) return true;
    }
    return false;
  };
  std::array<std::uint16_t, 3> request{0x0100, 0, 0};
  ASSERT_EQ(modbus_write_registers(master, commands, 3, request.data()), 3) << modbus_strerror(errno);
  EXPECT_TRUE(wait_for(0x31, 0x31));
  request = {0x0900, 0x0080, 0xFFFF};
  ASSERT_EQ(modbus_write_registers(master, commands, 3, request.data()), 3);
  EXPECT_TRUE(wait_for(0xC0, 0xC0));
  EXPECT_EQ(words[2] >> 8U, 0x80U);
  ASSERT_EQ(modbus_write_register(master, commands, 0x0100), 1) << modbus_strerror(errno);
  EXPECT_TRUE(wait_for(0x08, 0x00));
  ASSERT_EQ(modbus_read_registers(master, 0x07D0, 8, words.data()), 8);
  EXPECT_EQ(words[0] >> 8U, 0x31U);
  ASSERT_EQ(modbus_read_registers(master, 0x03E8, 2, words.data()), 2);
  EXPECT_EQ(words[1], 0x0080U) << "commands can be read back";
}

TEST(GripperSimulator, WritesBeforeItReadsInOneRequest) {
  IdealGripperPlant plant;
  const GripperSimulator simulator(plant, fast(true));
  for (const bool rtu : {false, true}) {
    modbus_t* master = rtu ? modbus_new_rtu(simulator.serial_path().c_str(), 115200, 'N', 8, 1)
                           : modbus_new_tcp("127.0.0.1", simulator.endpoint().port);
    modbus_set_slave(master, 9);
    modbus_set_response_timeout(master, 5, 0);
    ASSERT_EQ(modbus_connect(master), 0);
    const std::array<std::uint16_t, 3> go{0x0100, static_cast<std::uint16_t>(rtu ? 0x0040 : 0x0080), 0xFFFF};
    std::array<std::uint16_t, 3> words{};
    ASSERT_EQ(modbus_write_and_read_registers(master, 0x03E8, 3, go.data(), 0x07D0, 3, words.data()), 3)
        << modbus_strerror(errno);
    EXPECT_EQ(words[0] >> 8U & 0x01U, 1U);
    EXPECT_EQ(words[1], go[1]) << "the request is echoed";
    modbus_close(master);
    modbus_free(master);
  }
  modbus_t* master = modbus_new_tcp("127.0.0.1", simulator.endpoint().port);
  ASSERT_EQ(modbus_connect(master), 0);
  const std::array<std::uint16_t, 1> position{0x0011};
  std::array<std::uint16_t, 3> words{};
  EXPECT_EQ(modbus_write_and_read_registers(master, 0x03E9, 1, position.data(), 4000, 1, words.data()), -1);
  EXPECT_EQ(errno, EMBXILADD);
  EXPECT_EQ(modbus_read_registers(master, 0x03E8, 3, words.data()), 3);
  EXPECT_EQ(words[1], 0x0040U) << "a request that is refused writes nothing";
  modbus_close(master);
  modbus_free(master);
}

TEST(GripperSimulator, LibmodbusDrivesItOverTcpInBothLayouts) {
  IdealGripperPlant plant;
  const GripperSimulator simulator(plant, fast(false));
  for (const auto& [commands, status] : {std::pair{0, 0}, std::pair{0x03E8, 0x07D0}}) {
    modbus_t* master = modbus_new_tcp("127.0.0.1", simulator.endpoint().port);
    modbus_set_response_timeout(master, 5, 0);
    ASSERT_EQ(modbus_connect(master), 0);
    drive_by_libmodbus(master, commands, status);
    std::array<std::uint16_t, 8> words{};
    EXPECT_EQ(modbus_read_input_registers(master, 4000, 1, words.data()), -1);
    EXPECT_EQ(errno, EMBXILADD);
    modbus_close(master);
    modbus_free(master);
  }
}

// What the command line says to mbpoll, whose addresses count from 0 with -0.
std::string mbpoll(const std::string& arguments) {
  FILE* pipe = ::popen(("mbpoll -0 -1 -q -o 5 " + arguments + " 2>&1").c_str(), "r");
  std::string message;
  std::array<char, 256> piece{};
  while (pipe && std::fgets(piece.data(), static_cast<int>(piece.size()), pipe)) message += piece.data();
  if (pipe) ::pclose(pipe);
  return message;
}

TEST(GripperSimulator, MbpollDrivesItOnBothWires) {
  ASSERT_EQ(std::system("command -v mbpoll >/dev/null 2>&1"), 0) << "./dev packages installs mbpoll";
  IdealGripperPlant plant;
  const GripperSimulator simulator(plant, fast(true));
  const std::string tcp = concat("-m tcp -a 2 -p ", simulator.endpoint().port, ' '), host = " 127.0.0.1";
  const std::string rtu = "-m rtu -b 115200 -P none -a 9 ", line = ' ' + simulator.serial_path();
  const auto until = [](const std::string& wanted, const std::string& arguments) {
    std::string message;
    for (const Deadline limit = Deadline::in(kGripperLong); !limit.over();) {
      message = mbpoll(arguments);
      if (message.find(wanted) != std::string::npos) break;
    }
    return message;
  };
  EXPECT_THAT(mbpoll(tcp + "-t 4 -r 0" + host + " -- 256 0 0"), HasSubstr("Written 3 references"));
  EXPECT_THAT(until("0x3100", tcp + "-t 3:hex -r 0 -c 8" + host), HasSubstr("[0]: \t0x3100"));
  EXPECT_THAT(mbpoll(rtu + "-t 4 -r 1000" + line + " -- 2304 255 65535"), HasSubstr("Written 3 references"));
  EXPECT_THAT(until("0xF9FF", rtu + "-t 4:hex -r 2000 -c 3" + line), HasSubstr("[2000]: \t0xF9FF"));
  EXPECT_THAT(mbpoll(rtu + "-t 4:hex -r 1000 -c 3" + line), HasSubstr("[1001]: \t0x00FF"));
}

TEST(GripperSimulator, PymodbusDrivesItAsRobotiqsNodesDo) {
  const std::string python = "/usr/bin/python3 ";  // Debian's, which has Debian's pymodbus
  ASSERT_EQ(std::system((python + "-c 'import pymodbus.client' 2>/dev/null").c_str()), 0)
      << "./dev packages installs python3-pymodbus and what it imports";
  IdealGripperPlant plant;
  const GripperSimulator simulator(plant, fast(true));
  const std::string peer = python + STONESTACK_SOURCE_DIR "/tests/emulators/robotiq/peer_pymodbus.py ";
  EXPECT_EQ(std::system(concat(peer, simulator.endpoint().port, ' ', simulator.serial_path()).c_str()), 0);
}

TEST(GripperSimulator, LibmodbusDrivesItOverTheSerialLine) {
  IdealGripperPlant plant;
  const GripperSimulator simulator(plant, fast(true));
  modbus_t* master = modbus_new_rtu(simulator.serial_path().c_str(), 115200, 'N', 8, 1);
  modbus_set_slave(master, 9);
  modbus_set_response_timeout(master, 5, 0);
  ASSERT_EQ(modbus_connect(master), 0);
  drive_by_libmodbus(master, 0x03E8, 0x07D0);
  modbus_close(master);
  modbus_free(master);
}

class EveryPreset : public testing::TestWithParam<const char*> {};

TEST_P(EveryPreset, OurGripperGripsAndReleases) {
  IdealGripperPlant plant;
  const GripperSimulator simulator(plant, fast(true));
  ThreeFingerGripper gripper(client_options(simulator, GetParam()));
  EXPECT_FALSE(gripper.is_active());
  EXPECT_THAT([&] { gripper.move(0.05, 0.1, 30); },
              ThrowsMessage<DeviceError>(HasSubstr("is not activated")));
  gripper.activate();
  EXPECT_TRUE(gripper.is_active());
  GripperState state = gripper.move(0.155, 0.11, 15);
  EXPECT_FALSE(state.object);
  EXPECT_FALSE(state.moving);
  EXPECT_GT(state.opening, 0.145);
  plant.set_obstacles({120, 124, 118, 256});
  state = gripper.move(0.0, 0.11, 60);
  EXPECT_TRUE(state.object);
  EXPECT_NEAR(state.opening, 0.155 * (1 - 120.5 / 255), 0.001);
  EXPECT_TRUE(gripper.state().object);
  EXPECT_TRUE(gripper.state().fault.empty());
  plant.set_obstacles({256, 256, 256, 256});
  state = gripper.move(0.1, 0.11, 15);
  EXPECT_FALSE(state.object);
  EXPECT_NEAR(state.opening, 0.1, 0.001);
}

INSTANTIATE_TEST_SUITE_P(GripperSimulator, EveryPreset, testing::Values("tcp2018", "tcp2014", "rtu"));

TEST(GripperSimulator, AGripOnOneSideOnlyIsNoObject) {
  IdealGripperPlant plant;
  const GripperSimulator simulator(plant, fast(false));
  ThreeFingerGripper gripper(client_options(simulator, "tcp2018"));
  gripper.activate();
  plant.set_obstacles({256, 100, 100, 256});
  EXPECT_FALSE(gripper.move(0.0, 0.11, 60).object);
}

TEST(GripperSimulator, ModesAndIndividualFingers) {
  IdealGripperPlant plant;
  const GripperSimulator simulator(plant, fast(false));
  ThreeFingerOptions options = client_options(simulator, "tcp2018");
  options.mode = "wide";
  ThreeFingerGripper gripper(options);
  gripper.activate();
  EXPECT_EQ(gripper.status().mode, GripperMode::kWide) << "activation takes up the mode of the options";
  gripper.set_mode(GripperMode::kBasic);
  const auto status = gripper.move_fingers({{{50}, {100}, {150}}}, FingerRequest{80});
  EXPECT_EQ(status.axes[0].position, 50);
  EXPECT_EQ(status.axes[1].position, 100);
  EXPECT_EQ(status.axes[2].position, 150);
  EXPECT_EQ(status.axes[3].position, 80);
  EXPECT_NEAR(gripper.move(0.1, 0.11, 15).opening, 0.1, 0.001) << "simple control works again afterwards";
}

TEST(GripperSimulator, FingersBAndCDrawTogetherAndStaySo) {
  IdealGripperPlant plant;
  const GripperSimulator simulator(plant, fast(false));
  ThreeFingerGripper gripper(client_options(simulator, "tcp2018"));
  gripper.activate();
  gripper.move(0.155, 0.11, 15);
  gripper.spread(0.042);
  EXPECT_NEAR(gripper.status().axes[3].position, 220, 1);
  EXPECT_NEAR(gripper.move(0.1, 0.11, 15).opening, 0.1, 0.001);
  EXPECT_NEAR(gripper.status().axes[3].position, 220, 1) << "also when the fingers move";
  gripper.spread(0.073);
  EXPECT_NEAR(gripper.status().axes[3].position, 137, 1);
  EXPECT_THAT([&] { gripper.spread(0.02); }, ThrowsMessage<InvalidArgument>(HasSubstr("asked for 0.02")));
}

/// Works until it is broken.
struct FragileGripperPlant final : GripperPlant {
  void command(const std::array<AxisCommand, kGripperAxes>& axes) override { ideal.command(axes); }
  std::array<AxisReport, kGripperAxes> advance(double seconds) override {
    if (broken) throw DeviceError("plant", "is broken", "none");
    return ideal.advance(seconds);
  }
  IdealGripperPlant ideal;
  std::atomic<bool> broken{false};
};

TEST(GripperSimulator, AnErrorOfItsMechanicsDoesNotEndTheProcess) {
  FragileGripperPlant plant;
  const GripperSimulator simulator(plant, fast(false));
  ThreeFingerGripper gripper(client_options(simulator, "tcp2018"));
  gripper.activate();
  plant.broken = true;
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_TRUE(gripper.is_active()) << "the wire is still served";
}

TEST(GripperSimulator, ARestartedProgramStillKnowsThatItHoldsAStone) {
  IdealGripperPlant plant;
  const GripperSimulator simulator(plant, fast(false));
  {
    ThreeFingerGripper gripper(client_options(simulator, "tcp2018"));
    gripper.activate();
    plant.set_obstacles({120, 120, 120, 256});
    ASSERT_TRUE(gripper.move(0.0, 0.11, 60).object);
  }
  ThreeFingerGripper again(client_options(simulator, "tcp2018"));
  EXPECT_TRUE(again.is_active());
  EXPECT_TRUE(again.state().object);
}

TEST(GripperSimulator, ServesSeveralClients) {
  IdealGripperPlant plant;
  const GripperSimulator simulator(plant, fast(false));
  ThreeFingerGripper gripper(client_options(simulator, "tcp2018"));
  ThreeFingerGripper watcher(client_options(simulator, "tcp2014"));
  gripper.activate();
  EXPECT_TRUE(watcher.is_active());
}

TEST(GripperSimulator, StaysOnLoopback) {
  IdealGripperPlant plant;
  GripperSimulatorOptions options = fast(false);
  options.address = "0.0.0.0";
  EXPECT_THROW(GripperSimulator(plant, options), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::emulators
