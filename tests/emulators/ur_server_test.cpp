// The simulated controller over loopback sockets: every port, several clients, faults.
#include "emulators/ur/ur_controller_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <chrono>
#include <cstdlib>
#include <thread>

#include "core/socket.hpp"
#include "protocol/big_endian.hpp"
#include "script_bench.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

using ::testing::HasSubstr;

struct Server {
  explicit Server(UrServerOptions options = {}, double speed = 4.0)
      : server(at_speed(options, speed), robot, plant) {
    server.start();
  }
  static UrServerOptions at_speed(UrServerOptions options, double speed) {
    options.speed = speed;
    return options;
  }
  RobotModel robot = read_robot("ur10");
  IdealPlant plant{ScriptBench::start()};
  UrControllerServer server;
};

struct Client {
  explicit Client(int port) : stream(TcpStream::connect({"127.0.0.1", port}, Deadline::in(5))) {}
  void send(const std::string& bytes) { ASSERT_TRUE(stream.write_all(bytes, Deadline::in(5))); }
  /// All that comes until `wanted` is among it; empty at the deadline or the end of the link.
  std::string until(const std::string& wanted, double seconds = 10.0) {
    const Deadline deadline = Deadline::in(seconds);
    std::array<std::uint8_t, 4096> buffer;
    while (seen.find(wanted) == std::string::npos) {
      const auto result = stream.read_some(buffer, deadline);
      seen.append(reinterpret_cast<const char*>(buffer.data()), result.bytes);
      if (result.status == IoStatus::kClosed) closed = true;
      if (result.status != IoStatus::kDone) return "";
    }
    return seen;
  }
  std::string line() { return stream.read_line(1000, Deadline::in(10)).line; }
  std::string ask(const std::string& command) {
    send(command + "\n");
    return line();
  }
  std::string exact(std::size_t count) {
    std::string bytes(count, '\0');
    const auto result =
        stream.read_exact({reinterpret_cast<std::uint8_t*>(bytes.data()), bytes.size()}, Deadline::in(10));
    return result ? bytes : "";
  }
  TcpStream stream;
  std::string seen;
  bool closed = false;
};

TEST(UrServer, ProgramsRunAndReportOnThePrimaryPort) {
  Server bench;
  Client primary(bench.server.ports().primary), second(bench.server.ports().primary);
  EXPECT_NE(primary.until("URControl"), "") << "the version comes first";
  second.until("URControl");
  primary.send("def test_fun():\n  textmsg(\"still running\")\n  sleep(0.1)\n  sync()\nend\n");
  EXPECT_NE(primary.until("PROGRAM_XXX_STARTEDtest_fun"), "");
  EXPECT_NE(primary.until("still running"), "");
  EXPECT_NE(primary.until("PROGRAM_XXX_STOPPEDtest_fun"), "");
  EXPECT_NE(second.until("PROGRAM_XXX_STOPPEDtest_fun"), "") << "every primary client receives it";
  primary.send("def illegal_fun():\n  calldoesntexist()\nend\n");
  EXPECT_NE(primary.until("compile_error_name_not_found:calldoesntexist:"), "");
  primary.send("def endless():\n  while True:\n");
  EXPECT_NE(primary.until("syntax_error_on_line:"), "") << "a program without an end is one some time";
}

TEST(UrServer, ScriptsComeInOnAnyOfTheThreePorts) {
  Server bench;
  Client primary(bench.server.ports().primary);
  primary.until("URControl");
  Client secondary(bench.server.ports().secondary), realtime(bench.server.ports().realtime);
  secondary.send("def by_secondary():\n sync()\nend\n");
  EXPECT_NE(primary.until("PROGRAM_XXX_STOPPEDby_secondary"), "");
  realtime.send("def by_realtime():\n sync()\nend\nrun program\n");
  EXPECT_NE(primary.until("PROGRAM_XXX_STOPPEDby_realtime"), "");
  EXPECT_NE(secondary.until("URControl"), "");
  EXPECT_EQ(secondary.until("PROGRAM_XXX", 0.3), "") << "messages are for primary clients";
}

TEST(UrServer, ReadOnlyPortsAndLocalModeRefuseScripts) {
  Server bench;
  Client twin(bench.server.ports().primary_read_only);
  twin.until("URControl");
  twin.send("def no():\n sync()\nend\n");
  EXPECT_NE(twin.until(std::string("\0\0\0\xd2", 4)), "") << "C210";
  UrServerOptions options;
  options.version = "5.12.2.1101534";
  options.faults.local_mode = true;
  Server local(options);
  Client primary(local.server.ports().primary), dashboard(local.server.ports().dashboard);
  primary.until("URControl");
  primary.send("def no():\n sync()\nend\n");
  EXPECT_NE(primary.until(std::string("\0\0\0\xd2", 4)), "");
  EXPECT_EQ(primary.until("PROGRAM_XXX_STARTED", 0.3), "");
  dashboard.line();
  EXPECT_EQ(dashboard.ask("is in remote control"), "false");
}

TEST(UrServer, DashboardSpeaksLines) {
  Server bench;
  Client dashboard(bench.server.ports().dashboard);
  EXPECT_EQ(dashboard.line(), "Connected: Universal Robots Dashboard Server");
  EXPECT_EQ(dashboard.ask("robotmode"), "Robotmode: RUNNING");
  EXPECT_EQ(dashboard.ask("power off"), "Powering off");
  Client primary(bench.server.ports().primary);
  primary.send("set robotmode run\n");
  std::string mode;
  for (const Stopwatch watch; watch.seconds() < 10.0 && mode != "Robotmode: RUNNING";)
    mode = dashboard.ask("robotmode");
  EXPECT_EQ(mode, "Robotmode: RUNNING");
  EXPECT_EQ(dashboard.ask("quit"), "Disconnected");
  EXPECT_FALSE(dashboard.stream.read_line(10, Deadline::in(5)));
}

TEST(UrServer, StateArrivesAtItsRate) {
  Server bench;
  Client realtime(bench.server.ports().realtime);
  const std::string first = realtime.exact(1220), second = realtime.exact(1220);
  ASSERT_EQ(second.size(), 1220U);
  const auto time = [](const std::string& package) {
    std::uint64_t bits = 0;
    for (int i = 4; i < 12; ++i)
      bits = bits << 8 | static_cast<unsigned char>(package[static_cast<std::size_t>(i)]);
    return std::bit_cast<double>(bits);
  };
  EXPECT_NEAR(time(second) - time(first), 0.008, 1e-9);
}

/// A package of the primary or secondary port.
struct Package {
  int type = 0, kind = -1;  ///< 16: state, 20: message of that kind
  double time = 0.0;        ///< controller time [s]
  bool protective = false;  ///< of a state: protective stop
};

std::vector<Package> packages(std::string_view bytes) {
  std::vector<Package> list;
  while (bytes.size() > 5) {
    BigEndianReader in(bytes);
    const auto size = in.get<std::uint32_t>();
    if (size < 5 || size > bytes.size()) break;
    Package package;
    package.type = in.get<std::uint8_t>();
    if (package.type == 16) in.take(5);  // length and type of the first part
    package.time = 1e-9 * static_cast<double>(in.get<std::uint64_t>());
    if (package.type == 16)
      package.protective = in.take(5).back() != 0;
    else
      package.kind = in.take(2).back();
    list.push_back(package);
    bytes.remove_prefix(size);
  }
  return list;
}

TEST(UrServer, AStateShowsANewSafetyModeBeforeTheMessagesAboutIt) {
  constexpr double kStopAt = 0.5;
  UrServerOptions options;
  options.version = "5.12.2.1101534";
  options.faults.boot_seconds = 0;
  options.faults.protective_stop_at = kStopAt;
  Server bench(options, 1.0);
  Client primary(bench.server.ports().primary), secondary(bench.server.ports().secondary);
  EXPECT_NE(primary.until("fault switch"), "");
  secondary.until("no such text", 0.3);
  primary.send("set unlock protective stop\n");
  primary.until("no such text", 5.5);
  bool shown = false;
  std::vector<double> changes;
  for (const Package& package : packages(primary.seen)) {
    if (package.type == 16 && package.protective != shown) {
      shown = package.protective;
      changes.push_back(package.time);
    }
    if (package.type == 20 && package.kind == 5) {
      EXPECT_FALSE(changes.empty()) << "the message comes before the state";
      EXPECT_NEAR(package.time, changes.empty() ? 0.0 : changes.back(), 1e-9);
    }
  }
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_NEAR(changes[0], kStopAt, 0.003);
  EXPECT_NEAR(changes[1], kStopAt + 5.0, 0.003);
  double first = 0.0;
  for (const Package& package : packages(secondary.seen))
    if (package.protective && first == 0.0) first = package.time;
  EXPECT_NEAR(first, kStopAt, 0.003) << "secondary clients get the state, too";
}

const std::string kStart("\0\5V\0\2\0\x15O\x40\x5f\x40\0\0\0\0\0timestamp,\0\3S", 29);

TEST(UrServer, RtdeStreamsAndFaultsEndIt) {
  UrServerOptions options;
  options.faults.close_rtde_at = 4.0;
  Server bench(options);
  Client rtde(bench.server.ports().rtde);
  rtde.send(kStart);
  EXPECT_EQ(rtde.exact(4 + 10 + 4), std::string("\0\4V\1\0\12O\1DOUBLE\0\4S\1", 18));
  double before = 0;
  for (int k = 0; k < 50; ++k) {
    const std::string package = rtde.exact(12);
    ASSERT_EQ(package.substr(0, 4), std::string("\0\14U\1", 4));
    std::uint64_t bits = 0;
    for (std::size_t i = 4; i < 12; ++i) bits = bits << 8 | static_cast<unsigned char>(package[i]);
    const double now = std::bit_cast<double>(bits);
    if (k > 0) {
      EXPECT_NEAR(now - before, 0.008, 1e-6) << "no sample is missed";
    }
    before = now;
  }
  rtde.until("never");
  EXPECT_TRUE(rtde.closed);
  Client again(bench.server.ports().rtde);
  again.send(kStart);
  EXPECT_EQ(again.exact(4), std::string("\0\4V\1", 4)) << "a new link works, everything set up anew";
}

TEST(UrServer, FaultsOfTheLink) {
  UrServerOptions options;
  options.faults.split_packets = true;
  options.faults.message_before_reply = true;
  options.faults.refuse_protocol_2 = true;
  options.faults.no_dashboard = true;
  Server bench(options);
  EXPECT_EQ(bench.server.ports().dashboard, 0);
  Client rtde(bench.server.ports().rtde);
  rtde.send(std::string("\0\5V\0\2\0\x0cOtimestamp", 17));
  EXPECT_EQ(rtde.exact(4), std::string("\0\4V\0", 4));
  EXPECT_EQ(rtde.exact(3)[2], 'M');
  EXPECT_NE(rtde.until("DOUBLE"), "");

  UrServerOptions dead;
  dead.faults.drop_rtde_at = 1.0;
  Server mute(dead);
  Client client(mute.server.ports().rtde);
  client.send(kStart);
  EXPECT_EQ(client.until("never", 1.0), "");
  EXPECT_FALSE(client.closed) << "the link is up, but nothing comes any more";

  UrServerOptions restart;
  restart.faults.restart_rtde_at = 0.5;
  Server booting(restart);
  Client cut(booting.server.ports().rtde);
  cut.until("never", 3.0);
  EXPECT_TRUE(cut.closed);
  bool back = false;
  for (const Stopwatch watch; watch.seconds() < 10.0 && !back;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    try {
      Client next(booting.server.ports().rtde);
      next.send(kStart);
      back = !next.exact(4).empty();
    } catch (const DeviceError&) {  // refused while it restarts
    }
  }
  EXPECT_TRUE(back);

  UrServerOptions wrong;
  wrong.faults.out_of_step = true;
  Server broken(wrong);
  Client reader(broken.server.ports().rtde);
  reader.send(kStart);
  reader.exact(18 + 9 * 12);
  EXPECT_EQ(reader.exact(3), std::string("\0\2U", 3)) << "the tenth package has a length that cannot be";
}

TEST(UrServer, ASlowReaderIsSkippedAndThenDisconnected) {
  Server bench({}, 100.0);
  Client slow(bench.server.ports().rtde);
  slow.send(kStart);
  const double begin = bench.server.time();
  const Stopwatch watch;
  while (bench.server.time() < begin + 300.0 && watch.seconds() < 30.0)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  slow.until("never");  // what had been sent is there, then the link ends
  EXPECT_TRUE(slow.closed);
  EXPECT_LT(slow.seen.size(), 300.0 * 125 * 12 / 2) << "packages were left out";
  Client fresh(bench.server.ports().rtde);
  fresh.send(kStart);
  EXPECT_EQ(fresh.exact(18).size(), 18U);
}

TEST(UrServer, ScriptPortsSkipClientsThatOnlyWriteAndKeepThem) {
  // ur_rtde sends its programs over one connection to the realtime port and never reads what streams there.
  Server bench({}, 20.0);
  Client primary(bench.server.ports().primary), writer(bench.server.ports().realtime);
  primary.until("URControl");
  const double begin = bench.server.time();
  const Stopwatch watch;
  while (bench.server.time() < begin + 60.0 && watch.seconds() < 30.0)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  writer.send("def late():\n sync()\nend\n");
  EXPECT_NE(primary.until("PROGRAM_XXX_STOPPEDlate"), "");
  writer.until("never", 0.2);
  EXPECT_FALSE(writer.closed);
  EXPECT_LT(writer.seen.size(), 60.0 * 125 * 1220 / 2) << "packages were left out";
}

TEST(UrServer, LoopbackOnlyAndOccupiedPortsAreRefused) {
  const RobotModel robot = read_robot("ur10");
  IdealPlant plant(ScriptBench::start());
  UrServerOptions options;
  options.address = "0.0.0.0";
  EXPECT_THROW(UrControllerServer(options, robot, plant), InvalidArgument);
  options.address = "127.0.0.1";
  options.version = "4.1.0";
  EXPECT_THROW(UrControllerServer(options, robot, plant), InvalidArgument);
  options.version = "three";
  EXPECT_THROW(UrControllerServer(options, robot, plant), InvalidArgument);
  options.version = "3.15.8.106339";
  options.address = "127.45.67.89";
  options.standard_ports = true;
  UrControllerServer first(options, robot, plant), second(options, robot, plant);
  first.start();
  EXPECT_EQ(first.ports().rtde, 30004);
  EXPECT_THROW(second.start(), DeviceError);
  first.stop();
  second.start();
  EXPECT_EQ(second.ports().dashboard, 29999);
}

// A client written from the RTDE documentation alone, in another language.
// Clients in Python that share nothing with us but the protocol's description.
class Peer : public testing::TestWithParam<const char*> {
 protected:
  void run(const std::string& script, const std::vector<int>& ports) {
    ASSERT_EQ(std::system("command -v python3 >/dev/null 2>&1"), 0) << "./dev packages installs python3";
    std::string command = "python3 " STONESTACK_SOURCE_DIR "/tests/emulators/" + script;
    for (const int port : ports) command += " " + std::to_string(port);
    EXPECT_EQ(std::system(command.c_str()), 0);
  }
  static UrServerOptions options() {
    UrServerOptions options;
    options.version = GetParam();
    return options;
  }
};

TEST_P(Peer, RtdeAndAScript) {
  Server bench(options(), 1.0);
  run("peer_rtde.py", {bench.server.ports().rtde, bench.server.ports().primary});
}

TEST_P(Peer, AResidentScriptCommandedThroughRegisters) {
  Server bench(options(), 1.0);
  const auto& ports = bench.server.ports();
  run("peer_control.py", {ports.rtde, ports.realtime, ports.dashboard});
}

TEST_P(Peer, ADriverThatHasTheRobotDialBack) {
  Server bench(options(), 1.0);
  const auto& ports = bench.server.ports();
  run("peer_driver.py", {ports.rtde, ports.primary, ports.dashboard});
}

INSTANTIATE_TEST_SUITE_P(Versions, Peer, testing::Values("3.15.8.106339", "5.12.2.1101534"));

}  // namespace
}  // namespace stonestack::emulators
