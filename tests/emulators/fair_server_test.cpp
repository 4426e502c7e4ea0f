// No client of the simulated controller takes the control steps from the others: long scripts, floods of
// lines, listeners that do not answer, programs that blend for hours, too many connections.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "core/socket.hpp"
#include "emulators/tcp_service.hpp"
#include "emulators/ur/script_queue.hpp"
#include "script_bench.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string endless(const std::string& name) {
  return "def " + name + "():\n  while True:\n    sync()\n  end\nend\n";
}

/// Takes a while to compile.
std::string long_program(const std::string& name, const std::string& last_line) {
  std::string text = "def " + name + "():\n";
  for (int line = 0; line < 100000; ++line) text += "  x = 1\n";
  return text + last_line + "  while True:\n    sync()\n  end\nend\n";
}

struct QueueBench : ScriptBench {
  ScriptQueue queue{controller};
  void turn() {
    queue.turn();
    run(controller.period());
  }
  void turn_until(const std::string& key) {
    const Stopwatch watch;
    while (keys.find(key) == std::string::npos && exceptions.find(key) == std::string::npos &&
           watch.seconds() < 60) {
      turn();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
};

TEST(ScriptQueue, AShortScriptDoesNotWaitForALongOneOfAnotherClient) {
  QueueBench bench;
  bench.queue.put(1, long_program("bad", "  y = = 2\n"));
  bench.queue.put(2, endless("quick"));
  bench.turn();
  EXPECT_EQ(bench.keys, "PROGRAM_XXX_STARTED:quick|");
  EXPECT_EQ(bench.exceptions, "") << "the long one is still looked at";
  bench.turn_until("syntax_error");
  EXPECT_THAT(bench.exceptions, StartsWith("100002,7,syntax_error_on_line:100002:  y = = 2:"));
  EXPECT_EQ(bench.controller.program_name(), "quick") << "a broken program kills none";
}

TEST(ScriptQueue, ScriptsOfOneClientStayInOrder) {
  QueueBench bench;
  bench.queue.put(1, long_program("first", ""));
  bench.queue.put(1, " stop program\r");
  bench.queue.put(1, endless("second"));
  bench.turn_until("STARTED:second");
  EXPECT_EQ(bench.keys, "PROGRAM_XXX_STARTED:first|PROGRAM_XXX_STOPPED:first|PROGRAM_XXX_STARTED:second|");
  bench.queue.put(1, "power off");
  bench.turn();
  EXPECT_EQ(bench.controller.robot_mode, RobotMode::kPowerOff);
}

TEST(ScriptQueue, AFloodTakesAHandfulOfLinesAStep) {
  QueueBench bench;
  for (int line = 0; line < 10000; ++line) bench.queue.put(1, "nonsense here");
  bench.queue.put(2, endless("calm"));
  EXPECT_TRUE(bench.queue.is_full(1)) << "the rest waits in its socket";
  EXPECT_FALSE(bench.queue.is_full(2));
  bench.queue.turn();
  bench.queue.turn();
  EXPECT_LE(bench.controller.take_events().size(), 200U);
  EXPECT_EQ(bench.controller.program_name(), "calm");
}

// A backlog of one that is full: the kernel lets whoever calls wait.
TEST(FairServer, AListenerThatDoesNotAnswerHoldsUpNobody) {
  ListenOptions options;
  options.waiting = 0;
  const TcpListener listener(options);
  std::vector<TcpStream> waiting;
  try {
    for (int k = 0; k < 8; ++k) waiting.push_back(TcpStream::connect(listener.endpoint(), Deadline::in(0.2)));
    GTEST_SKIP() << "this kernel takes them all";
  } catch (const Error&) {  // now it is full
  }
  ScriptBench bench;
  bench.controller.run_script(
      "def a():\n  set_standard_digital_out(0, True)\n  there = socket_open(\"127.0.0.1\", " +
      std::to_string(listener.endpoint().port) +
      ")\n  set_standard_digital_out(1, True)\n  textmsg(there)\n  sync()\nend\n");
  bench.run(0.1);
  EXPECT_EQ(bench.controller.io.digital_out, 1U) << "the controller goes on while the program waits";
  bench.run(0.2);
  EXPECT_EQ(bench.texts, "False");
}

TEST(FairServer, ABlendedPathForgetsFinishedMoves) {
  ScriptBench bench;
  bench.controller.run_script(
      "def a():\n  i = 0\n  while i < 200:\n"
      "    movej([0.1, -1.3, 1.6, -1.8, -1.5, 0.3], a=10, v=2, r=0.005)\n"
      "    movej([0.1, -1.3, 1.6, -1.8, -1.5, 0.2], a=10, v=2, r=0.005)\n    i = i + 1\n  end\n"
      "  p0 = get_forward_kin([0.1, -1.3, 1.6, -1.8, -1.5, 0.2])\n  j = 0\n  while j < 20:\n"
      "    movel(pose_add(p0, p[0, 0.05, 0, 0, 0, 0]), a=5, v=1, r=0.01)\n"
      "    movel(p0, a=5, v=1, r=0.01)\n    j = j + 1\n  end\n"
      "  movel(pose_add(p0, p[0, 0, 0.05, 0, 0, 0]))\nend\n");
  const Pose start = bench.controller.motion.geometry().T_B_P(ScriptBench::start());
  std::size_t max = 0;
  for (int step = 0; step < 125 * 300 && bench.controller.runtime() != RuntimeState::kStopped; ++step) {
    bench.run(bench.controller.period());
    max = std::max(max, bench.controller.motion.moves_in_progress());
  }
  EXPECT_EQ(bench.exceptions + bench.errors, "");
  EXPECT_EQ(bench.controller.runtime(), RuntimeState::kStopped);
  EXPECT_LE(max, 4U);
  bench.run(0.5);
  const Pose end = bench.controller.motion.geometry().T_B_P(bench.plant.state().q);
  EXPECT_LT((end.translation() - start.translation() - Eigen::Vector3d(0, 0, 0.05)).norm(), 1e-6);
}

TEST(FairServer, OutOfSocketsItServesThoseWhoAreThere) {
  RobotModel robot = read_robot("ur10");
  IdealPlant plant{ScriptBench::start()};
  UrControllerServer server({}, robot, plant);
  server.start();
  const Endpoint dashboard{"127.0.0.1", server.ports().dashboard};
  TcpStream first = TcpStream::connect(dashboard, Deadline::in(5));
  EXPECT_THAT(first.read_line(1000, Deadline::in(10)).line, HasSubstr("Connected"));
  const int late = ::socket(AF_INET, SOCK_STREAM, 0);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit none{3, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(dashboard.port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::connect(late, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  const double now = server.time();
  const Stopwatch watch;
  while (server.time() < now + 0.1 && watch.seconds() < 10)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  ASSERT_TRUE(first.write_all(std::string_view("robotmode\n"), Deadline::in(5)));
  EXPECT_EQ(first.read_line(1000, Deadline::in(10)).line, "Robotmode: RUNNING");
  TcpStream heard(Descriptor(late), "late");
  EXPECT_THAT(heard.read_line(1000, Deadline::in(10)).line, HasSubstr("Connected")) << "its turn comes";
}

TEST(FairServer, AServiceThatIsOutOfSocketsWarnsOnceAndGoesOn) {
  TcpService service({}, [](TcpStream& stream) {
    static_cast<void>(stream.write_all(std::string_view("welcome\n"), Deadline::in(5)));
  });
  const int late = ::socket(AF_INET, SOCK_STREAM, 0);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  testing::internal::CaptureStderr();
  const rlimit none{3, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(service.endpoint().port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::connect(late, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  TcpStream heard(Descriptor(late), "late");
  EXPECT_EQ(heard.read_line(1000, Deadline::in(10)).line, "welcome") << "its turn comes";
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 1) << log.substr(0, 1000);
  EXPECT_THAT(log, HasSubstr(to_text(service.endpoint())));
}

TEST(FairServer, ANinthSecondaryProgramIsRefusedAndReported) {
  ScriptBench bench;
  for (int k = 0; k < 8; ++k) bench.controller.run_script("sec s():\n  sleep(5)\nend\n");
  bench.run(0.1);
  EXPECT_EQ(bench.exceptions, "");
  bench.controller.run_script("sec s():\n  set_standard_digital_out(0, True)\nend\n");
  bench.run(0.1);
  EXPECT_THAT(bench.exceptions, HasSubstr("more than 8 secondary programs"));
  EXPECT_EQ(bench.controller.io.digital_out, 0U);
}

}  // namespace
}  // namespace stonestack::emulators
