#include "emulators/robotiq/ft_simulator.hpp"

#include <gmock/gmock.h>
#include <modbus/modbus.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <thread>
#include <vector>

#include "core/byte_stream.hpp"
#include "core/serial.hpp"
#include "hardware/robotiq/ft_sensor.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

using Bytes = std::vector<std::uint8_t>;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kLong = 10.0;  // s

struct SensorBench {
  IdealWrenchPlant plant;
  std::unique_ptr<FtSimulator> simulator;
  FtSensorOptions options;

  explicit SensorBench(const std::string& link = "serial", bool streaming = false) {
    FtSimulatorOptions served;
    served.cap = true;
    served.port = served.command_port = 0;
    served.streaming = streaming;
    simulator = std::make_unique<FtSimulator>(plant, served);
    options.link = link;
    options.device = simulator->serial_path();
    options.port = simulator->stream_endpoint().port;
    // Other programs share this machine with the test: patience here, limits where a test is about them.
    options.stale = 1.0;
    options.start_timeout = kLong;
  }
  void push(double fz) {
    Wrench wrench;
    wrench.force.z() = fz;
    plant.set(wrench);
  }
  void arm(const FtFaults& faults) const { simulator->set_faults(faults); }
};

double read_until(RobotiqFtSensor& sensor, double fz) {
  double force = 0.0;
  for (const Deadline limit = Deadline::in(kLong); std::abs(force - fz) > 0.1 && !limit.over();)
    force = sensor.read().force.z();
  return force;
}

TEST(FtSimulator, AnswersTheManualsFrameAndStreamsAfterRegister410) {
  SensorBench bench;
  bench.push(-12.5);
  SerialPort line = SerialPort::open(bench.simulator->serial_path(), 19200);
  const Bytes read_all{0x09, 0x03, 0x00, 0xB4, 0x00, 0x06, 0x84, 0xA6};
  Bytes reply(17);
  for (const Deadline limit = Deadline::in(kLong); !limit.over();) {
    ASSERT_TRUE(line.write_all(read_all, Deadline::in(kLong)));
    ASSERT_TRUE(line.read_exact(reply, Deadline::in(kLong)));
    if (reply[7] != 0) break;  // the first sample has been taken
  }
  EXPECT_EQ((Bytes{reply.begin(), reply.begin() + 3}), (Bytes{0x09, 0x03, 0x0C}));
  EXPECT_NEAR(static_cast<std::int16_t>(reply[7] * 256 + reply[8]), -1250, 1) << "Fz, hundredths of a newton";
  const Bytes start{0x09, 0x10, 0x01, 0x9A, 0x00, 0x01, 0x02, 0x02, 0x00, 0xCD, 0xCA};
  ASSERT_TRUE(line.write_all(start, Deadline::in(kLong)));
  Bytes echo(8), frames(48);
  ASSERT_TRUE(line.read_exact(echo, Deadline::in(kLong)));
  EXPECT_EQ((Bytes{echo.begin(), echo.begin() + 6}), (Bytes{0x09, 0x10, 0x01, 0x9A, 0x00, 0x01}));
  ASSERT_TRUE(line.read_exact(frames, Deadline::in(kLong)));
  for (std::size_t i = 0; i < 48; i += 16) {
    EXPECT_EQ(frames[i], 0x20);
    EXPECT_EQ(frames[i + 1], 0x4E);
    EXPECT_NEAR(static_cast<std::int16_t>(frames[i + 6] + 256 * frames[i + 7]), -1250, 1);
  }
}

TEST(FtSimulator, LibmodbusReadsWhoItIsAndTheJamStopsTheStream) {
  SensorBench bench("serial", true);
  {
    SerialPort line = SerialPort::open(bench.simulator->serial_path(), 19200);
    ASSERT_TRUE(line.write_all(Bytes(50, 0xFF), Deadline::in(kLong)));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    line.discard_input();
    Bytes nothing(1);
    EXPECT_EQ(line.read_some(nothing, Deadline::in(0.1)).status, IoStatus::kTimeOut);
  }
  modbus_t* master = modbus_new_rtu(bench.simulator->serial_path().c_str(), 19200, 'N', 8, 1);
  modbus_set_slave(master, 9);
  modbus_set_response_timeout(master, 5, 0);
  ASSERT_EQ(modbus_connect(master), 0);
  std::array<std::uint16_t, 6> words{};
  ASSERT_EQ(modbus_read_registers(master, 500, 6, words.data()), 6) << modbus_strerror(errno);
  EXPECT_EQ(words[0] >> 8U, static_cast<unsigned>('F'));
  EXPECT_EQ(words[1], 'S' << 8 | 2);
  EXPECT_EQ(words[2], 0x0001U) << "version 2.0.1";
  ASSERT_EQ(modbus_read_registers(master, 514, 1, words.data()), 1);
  EXPECT_EQ(words[0], 2016);
  ASSERT_EQ(modbus_read_registers(master, 180, 6, words.data()), 6);
  EXPECT_EQ(modbus_read_registers(master, 900, 1, words.data()), -1);
  modbus_set_response_timeout(master, 0, 100000);
  words[0] = 0x0200;
  EXPECT_EQ(modbus_write_and_read_registers(master, 410, 1, words.data(), 410, 1, words.data()), -1)
      << "the sensor has no function 23";
  modbus_set_response_timeout(master, 5, 0);
  ASSERT_EQ(modbus_read_registers(master, 410, 1, words.data()), 1) << modbus_strerror(errno);
  EXPECT_EQ(words[0], 0U) << "and did not start its stream";
  modbus_close(master);
  modbus_free(master);
}

TEST(FtSimulator, AnErrorOfItsMechanicsIsSilenceAndDoesNotEndTheProcess) {
  struct BrokenWrenchPlant final : WrenchPlant {
    Wrench sample(double /*seconds*/) override { throw DeviceError("plant", "is broken", "none"); }
  };
  BrokenWrenchPlant plant;
  FtSimulator simulator(plant, {});
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  FtSensorOptions options;
  options.device = simulator.serial_path();
  options.start_timeout = 0.3;
  EXPECT_THROW(RobotiqFtSensor sensor(options), DeviceError);
}

TEST(FtSimulator, ADriverThatFindsTheSensorStreamingOrNotStartsIt) {
  ASSERT_EQ(std::system("command -v python3 >/dev/null 2>&1"), 0) << "./dev packages installs python3";
  for (const bool streaming : {false, true}) {
    SensorBench bench("serial", streaming);
    bench.push(-12.5);
    const std::string peer = "python3 " STONESTACK_SOURCE_DIR "/tests/emulators/robotiq/peer_ft.py ";
    EXPECT_EQ(std::system((peer + bench.simulator->serial_path() + " -12.5").c_str()), 0) << streaming;
  }
}

TEST(FtSimulator, TheCapZeroesItsOwnStreamOnCommand) {
  SensorBench bench("ur_cap");
  bench.push(30.0);
  RobotiqFtSensor sensor(bench.options);
  EXPECT_NEAR(read_until(sensor, 30.0), 30.0, 0.1);
  TcpStream commands = TcpStream::connect(bench.simulator->command_endpoint(), Deadline::in(kLong));
  ASSERT_TRUE(commands.write_all("SET ZRO", Deadline::in(kLong)));
  Bytes done(4);
  ASSERT_TRUE(commands.read_exact(done, Deadline::in(kLong)));
  EXPECT_EQ((std::string{done.begin(), done.end()}), "Done");
  EXPECT_NEAR(read_until(sensor, 0.0), 0.0, 0.1);
}

class EveryFtLink : public testing::TestWithParam<const char*> {};

TEST_P(EveryFtLink, ReadsZeroesAndReadsTheDifference) {
  SensorBench bench(GetParam());
  bench.push(20.0);
  RobotiqFtSensor sensor(bench.options);
  EXPECT_NEAR(read_until(sensor, 20.0), 20.0, 0.1);
  sensor.zero();
  EXPECT_NEAR(sensor.read().force.z(), 0.0, 0.1);
  bench.push(25.0);
  EXPECT_NEAR(read_until(sensor, 5.0), 5.0, 0.1);
  const double first = sensor.read().device_time;
  EXPECT_GT(sensor.read().device_time, first) << "no reading is returned twice";
}

TEST_P(EveryFtLink, GarbledFramesAreSkippedNeverRead) {
  SensorBench bench(GetParam());
  bench.push(-7.0);
  RobotiqFtSensor sensor(bench.options);
  EXPECT_NEAR(read_until(sensor, -7.0), -7.0, 0.1);
  for (int FtFaults::*fault : {&FtFaults::bad_crc, &FtFaults::lost_bytes, &FtFaults::noise}) {
    const long before = sensor.health().bad_bytes;
    FtFaults faults;
    faults.*fault = 5;
    faults.split = true;
    bench.arm(faults);
    for (int i = 0; i < 15; ++i) EXPECT_NEAR(sensor.read().force.z(), -7.0, 0.1);
    const bool garbles = fault != &FtFaults::bad_crc || bench.options.link == "serial";
    EXPECT_EQ(sensor.health().bad_bytes > before, garbles);
  }
  EXPECT_EQ(sensor.health().restarts, 0);
}

TEST_P(EveryFtLink, SilenceIsAnErrorAndPassesWhenTheSensorComesBack) {
  SensorBench bench(GetParam());
  bench.options.stale = 0.2;
  RobotiqFtSensor sensor(bench.options);
  FtFaults faults;
  faults.silent = true;
  bench.arm(faults);
  EXPECT_THAT(
      [&] {
        for (int i = 0; i < 100; ++i) (void)sensor.read();
      },
      ThrowsMessage<DeviceError>(AllOf(HasSubstr("Robotiq force sensor"), HasSubstr("no reading for"))));
  bench.arm(FtFaults{});
  bool back = false;
  for (const Deadline limit = Deadline::in(kLong); !back && !limit.over();) {
    try {
      (void)sensor.read();
      back = true;
    } catch (const DeviceError&) {
    }
  }
  EXPECT_TRUE(back);
}

TEST_P(EveryFtLink, TenReadingsASecondAreTooFew) {
  SensorBench bench(GetParam());
  bench.options.stale = 0.05;
  RobotiqFtSensor strict(bench.options);
  FtFaults faults;
  faults.rate = 2.0;
  bench.arm(faults);
  EXPECT_THAT(
      [&] {
        for (int i = 0; i < 5; ++i) (void)strict.read();
      },
      ThrowsMessage<DeviceError>(HasSubstr("allowed 0.05 s")));
}

TEST_P(EveryFtLink, AStuckOrDeadReadingIsAnError) {
  for (bool FtFaults::*fault : {&FtFaults::stuck, &FtFaults::zeros}) {
    SensorBench bench(GetParam());
    bench.options.stuck_samples = 20;
    RobotiqFtSensor sensor(bench.options);
    FtFaults faults;
    faults.*fault = true;
    bench.arm(faults);
    EXPECT_THAT(
        [&] {
          for (int i = 0; i < 100; ++i) (void)sensor.read();
        },
        ThrowsMessage<DeviceError>(HasSubstr("repeats one reading")));
  }
}

TEST_P(EveryFtLink, SaturationAndSpikesBeyondTheRangeAreErrors) {
  SensorBench bench(GetParam());
  RobotiqFtSensor sensor(bench.options);
  FtFaults faults;
  faults.saturated = true;
  bench.arm(faults);
  EXPECT_THAT(
      [&] {
        for (int i = 0; i < 20; ++i) (void)sensor.read();
      },
      ThrowsMessage<DeviceError>(HasSubstr("beyond its range")));
}

TEST_P(EveryFtLink, AMovingLoadCannotBeZeroed) {
  SensorBench bench(GetParam());
  RobotiqFtSensor sensor(bench.options);
  FtFaults faults;
  faults.drift = 100.0;
  bench.arm(faults);
  EXPECT_THAT([&] { sensor.zero(); }, ThrowsMessage<DeviceError>(HasSubstr("is not at rest")));
}

INSTANTIATE_TEST_SUITE_P(FtSimulator, EveryFtLink, testing::Values("serial", "ur_cap"));

TEST(FtSensor, TakesOverASensorThatStreamsAlready) {
  SensorBench bench("serial", true);
  bench.options.listen = 5.0;
  RobotiqFtSensor sensor(bench.options);
  (void)sensor.read();
  EXPECT_EQ(sensor.firmware(), "") << "it was not asked";
}

TEST(FtSensor, StartsASilentSensorAndAsksWhoItIs) {
  SensorBench bench;
  RobotiqFtSensor sensor(bench.options);
  EXPECT_EQ(sensor.firmware(), "FTS-2.0.1");
}

TEST(FtSensor, RefusesAnotherDeviceOnTheLine) {
  SensorBench bench;
  FtFaults faults;
  faults.firmware = "GRIPPER";
  bench.arm(faults);
  EXPECT_THAT([&] { RobotiqFtSensor sensor(bench.options); },
              ThrowsMessage<DeviceError>(HasSubstr("has firmware 'GRI-")));
}

TEST(FtSensor, AMissingSensorEndsAtTheDeadlineWithLineAndRate) {
  SensorBench bench;
  FtFaults faults;
  faults.silent = true;
  bench.arm(faults);
  bench.options.start_timeout = 0.5;
  EXPECT_THAT([&] { RobotiqFtSensor sensor(bench.options); },
              ThrowsMessage<DeviceError>(AllOf(HasSubstr(bench.options.device), HasSubstr("sends nothing"),
                                               HasSubstr("19200 baud"))));
}

TEST(FtSensor, GarbageOnTheLineIsShownInTheError) {
  SensorBench bench("serial", true);
  FtFaults faults;
  faults.deaf = true;
  faults.bad_crc = -1;
  bench.arm(faults);
  bench.options.start_timeout = 0.5;
  EXPECT_THAT([&] { RobotiqFtSensor sensor(bench.options); },
              ThrowsMessage<DeviceError>(AllOf(HasSubstr("no valid frame, last"), HasSubstr("20 4E"))));
}

TEST(FtSensor, StartsTheStreamAgainAfterAPowerCycle) {
  SensorBench bench;
  RobotiqFtSensor sensor(bench.options);
  FtFaults faults;
  faults.forgets = true;
  bench.arm(faults);
  for (const Deadline limit = Deadline::in(kLong); sensor.health().restarts == 0 && !limit.over();) {
    try {
      (void)sensor.read();
    } catch (const DeviceError&) {
    }
  }
  EXPECT_GE(sensor.health().restarts, 1);
  bench.push(9.0);
  EXPECT_NEAR(read_until(sensor, 9.0), 9.0, 0.1);
}

TEST(FtSensor, TurnsIntoTheFlangesAxes) {
  SensorBench bench;
  Wrench wrench;
  wrench.force.x() = 10.0;
  bench.plant.set(wrench);
  bench.options.yaw = 1.5707963267948966;
  RobotiqFtSensor sensor(bench.options);
  double force = 0.0;
  for (const Deadline limit = Deadline::in(kLong); force < 9.0 && !limit.over();)
    force = sensor.read().force.y();
  EXPECT_NEAR(force, 10.0, 0.1);
}

}  // namespace
}  // namespace stonestack::emulators
