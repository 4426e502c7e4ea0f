// Peers that never stop talking, trickle, or send nothing: every call ends at its deadline with an error, and
// at Ctrl-C. The walls of time are no measurement: they distinguish an end from a hang.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "hardware/camera/stream_camera.hpp"
#include "hardware/fake_rtde.hpp"
#include "hardware/fake_server.hpp"
#include "hardware/robotiq/ft_sensor.hpp"
#include "hardware/robotiq/modbus.hpp"
#include "hardware/ur/dashboard_client.hpp"
#include "hardware/ur/primary_client.hpp"
#include "hardware/ur/rtde_client.hpp"
#include "protocol/hex.hpp"
#include "stonestack/core/clock.hpp"

namespace stonestack::hardware {
namespace {

using testing::AllOf;
using testing::ExitedWithCode;
using testing::HasSubstr;

constexpr double kHang = 20.0;  // s

/// Sends `bytes` again and again from the first byte that it hears, or at once.
FakeServer::Serve flood(const std::string& bytes, bool at_once) {
  return [=](TcpStream& stream, int) {
    std::array<std::uint8_t, 512> heard{};
    if (!at_once && !stream.read_some(heard, Deadline::in(2.0))) return;
    const Deadline end = Deadline::in(1.5 * kHang);  // without the fix the client would end then, not never
    while (!end.over() && stream.write_all(bytes, Deadline::in(1.0))) continue;
  };
}

std::string repeat(const std::string& bytes, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += bytes;
  return all;
}

/// Error of a call, if it comes in time.
template <class Call>
std::string prompt_error_of(Call&& call) {
  const Stopwatch watch;
  std::string problem;
  try {
    call();
  } catch (const DeviceError& error) {
    problem = error.what();
  }
  EXPECT_LT(watch.seconds(), kHang);
  return problem;
}

RtdeOptions quick_rtde() {
  RtdeOptions options;
  options.attempts = 1;
  options.reply_timeout = options.silent_after = 0.2;
  options.boot_timeout = 1.0;
  options.retry_pause = 0.02;
  return options;
}

RtdeRecipe joints_recipe(const UrVersion&) {
  return {{"actual_q"}, {}, {}};
}

const std::string kText = hex("00 0C 4D 02 'Hi' 04 'RTDE' 02");

TEST(HostilePeers, RtdeTextsWithoutEndDuringTheSetup) {
  FakeServer server(flood(repeat(hex("00 08 4D 02 'Hi' 00 02"), 4000), false));
  EXPECT_THAT(prompt_error_of([&] { RtdeClient(server.endpoint(), joints_recipe, quick_rtde()); }),
              HasSubstr("no reply to 'V' within 0.2 s"));
}

TEST(HostilePeers, RtdeTextsWithoutEndInsteadOfData) {
  FakeRtde server([](int) {
    FakeRtdePlan plan;
    plan.replies = {{'V', {hex("00 04 56 01")}},
                    {'v', {hex("00 13 76 00000003 0000000F 00000008 00019F63")}},
                    {'O', {hex("00 13 4F 01 'DOUBLE,VECTOR6D'")}},
                    {'S', {hex("00 04 53 01")}}};
    plan.data = [](long) { return repeat(kText, 1000); };
    return plan;
  });
  EXPECT_THAT(prompt_error_of([&] { RtdeClient(server.endpoint(), joints_recipe, quick_rtde()); }),
              AllOf(HasSubstr("boot"), HasSubstr("127.0.0.1")));
  EXPECT_GE(server.connections(), 2) << "no data is a lost link, whatever else arrives";
}

ModbusOptions quick_modbus(int port) {
  ModbusOptions options;
  options.port = port;
  options.reply_timeout = 0.1;
  options.attempts = 2;
  return options;
}

TEST(HostilePeers, ModbusRepliesToOthersWithoutEnd) {
  FakeServer server(flood(repeat(hex("9999 0000 0005 02 04 02 0000"), 4000), false));
  ModbusClient client("Robotiq gripper", quick_modbus(server.port()));
  EXPECT_THAT(prompt_error_of([&] { static_cast<void>(client.read_input(0, 1)); }),
              AllOf(HasSubstr("127.0.0.1:"), HasSubstr("to other requests")));
}

FtSensorOptions cap(int port) {
  FtSensorOptions options;
  options.link = "ur_cap";
  options.port = port;
  options.start_timeout = 0.5;
  return options;
}

TEST(HostilePeers, AForceSensorOfGarbageWithoutEnd) {
  FakeServer server(flood(repeat("(1 , 2 , nan , x)", 2000), true));
  EXPECT_THAT(prompt_error_of([&] { RobotiqFtSensor(cap(server.port())); }),
              AllOf(HasSubstr("Robotiq force sensor at 127.0.0.1:"), HasSubstr("no valid frame")));
}

TEST(HostilePeers, AForceSensorThatIsNotThereIsNamed) {
  int port = 0;
  {
    const TcpListener listener{ListenOptions{}};
    port = listener.endpoint().port;
  }
  EXPECT_THAT(prompt_error_of([&] { RobotiqFtSensor(cap(port)); }),
              AllOf(HasSubstr("Robotiq force sensor at 127.0.0.1:"), HasSubstr("connection refused")));
  FtSensorOptions serial;
  serial.device = "/dev/ttyNothing";
  EXPECT_THAT(prompt_error_of([&] { RobotiqFtSensor sensor(serial); }),
              AllOf(HasSubstr("Robotiq force sensor on /dev/ttyNothing"), HasSubstr("cannot be opened"),
                    HasSubstr("force_torque.device")));
}

TEST(HostilePeers, ACameraOfGarbageWithoutEnd) {
  FakeServer server(flood(std::string(4096, 'x'), false));
  StreamCameraOptions options;
  options.port = server.port();
  options.frame_timeout = 0.2;
  options.attempts = 1;
  StreamCamera camera(options);
  EXPECT_THAT(prompt_error_of([&] { static_cast<void>(camera.capture()); }),
              HasSubstr("depth camera at 127.0.0.1:"));
}

TEST(HostilePeers, ADashboardThatNeverStopsGreeting) {
  FakeServer server(flood(repeat("Connected: Universal Robots Dashboard Server\n", 500), true));
  DashboardClient dashboard(server.endpoint(), {0.5, 0.2, 0.2});
  EXPECT_THAT(prompt_error_of([&] { static_cast<void>(dashboard.robot_mode()); }), HasSubstr("Connected"));
}

/// Runs `call` in a process of its own in which Ctrl-C was pressed: 130 if it ends as Interrupted.
template <class Call>
void expect_interrupted(const Call& call) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        std::thread user([] {
          std::this_thread::sleep_for(std::chrono::milliseconds(100));
          note_interrupt();
        });
        int code = 0;
        try {
          call();
        } catch (const Interrupted&) {
          code = 130;
        } catch (const DeviceError&) {
          code = 6;
        }
        user.join();
        std::_Exit(code);
      },
      ExitedWithCode(130), "");
}

/// Accepts connections by its backlog and never sends anything.
struct Silence {
  TcpListener listener{ListenOptions{}};
  [[nodiscard]] int port() const { return listener.endpoint().port; }
};

TEST(HostilePeers, CtrlCEndsTheWaitForASilentController) {
  expect_interrupted([] {
    const Silence silence;
    RtdeOptions options = quick_rtde();
    options.reply_timeout = kHang;
    RtdeClient({"127.0.0.1", silence.port()}, joints_recipe, options);
  });
  expect_interrupted([] {
    const Silence silence;
    const PrimaryClient client("127.0.0.1", {{silence.port()}, 0.5, 0.5});
    client.wait_until_heard(Deadline::in(kHang));
  });
  expect_interrupted([] {
    const Silence silence;
    DashboardClient dashboard({"127.0.0.1", silence.port()}, {0.5, kHang, kHang});
    static_cast<void>(dashboard.robot_mode());
  });
}

TEST(HostilePeers, CtrlCEndsTheWaitForSilentDevices) {
  expect_interrupted([] {
    const Silence silence;
    ModbusOptions options = quick_modbus(silence.port());
    options.reply_timeout = 10.0;
    ModbusClient client("Robotiq gripper", options);
    static_cast<void>(client.read_input(0, 1));
  });
  expect_interrupted([] {
    const Silence silence;
    FtSensorOptions options = cap(silence.port());
    options.start_timeout = kHang;
    RobotiqFtSensor sensor(options);
  });
  expect_interrupted([] {
    const Silence silence;
    StreamCameraOptions options;
    options.port = silence.port();
    options.frame_timeout = kHang;
    StreamCamera camera(options);
    static_cast<void>(camera.capture());
  });
}

}  // namespace
}  // namespace stonestack::hardware
