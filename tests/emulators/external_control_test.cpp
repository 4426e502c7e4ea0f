// A program on the pendant that asks a host for what to run, as UR's client library expects it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "core/socket.hpp"
#include "script_bench.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

using ::testing::HasSubstr;

/// The host; and a controller with the URCap, that asks it.
struct Pendant {
  TcpListener host{{}};
  RobotModel robot = read_robot("ur10");
  IdealPlant plant{ScriptBench::start()};
  UrController controller{options(host.endpoint().port), robot, plant};
  std::string texts, exceptions;

  static UrServerOptions options(int port) {
    UrServerOptions options;
    options.external_control = port;
    return options;
  }
  Pendant() { controller.loaded_program = kExternalControl; }
  void run(double seconds) {
    for (double t = 0; t < seconds; t += controller.period()) {
      controller.step();
      for (const auto& event : controller.take_events()) {
        if (event.kind == ControllerEvent::Kind::kText) texts += event.text + "|";
        if (event.kind == ControllerEvent::Kind::kRuntimeException) exceptions += event.text;
      }
    }
  }
  /// Answers the controller with `script`, and reads what it asked for.
  std::string answer(const std::string& script) {
    run(0.1);
    auto link = host.accept(Deadline::in(10.0));
    if (!link) return "nobody came";
    std::array<std::uint8_t, 64> buffer{};
    const auto asked = link->read_some(buffer, Deadline::in(10.0));
    const std::string request(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(asked.bytes));
    EXPECT_TRUE(link->write_all(std::string_view(script), Deadline::in(10.0)));
    for (int k = 0; k < 100 && texts.empty() && exceptions.empty(); ++k) run(0.02);
    return request;
  }
};

TEST(ExternalControl, RunsWhatTheHostAnswers) {
  Pendant pendant;
  ASSERT_TRUE(pendant.controller.play_loaded());
  EXPECT_EQ(pendant.answer(
                "# HEADER_BEGIN\ndef f():\n  return 7\nend\n# HEADER_END\n"
                "# NODE_CONTROL_LOOP_BEGINS\ntextmsg(\"here \", f())\nsleep(1)\n# NODE_CONTROL_LOOP_ENDS\n"),
            "request_program\n");
  EXPECT_EQ(pendant.texts, "here 7|");
  EXPECT_TRUE(pendant.controller.program_running());
  pendant.run(1.5);
  EXPECT_FALSE(pendant.controller.program_running());
  EXPECT_EQ(pendant.exceptions, "");
}

TEST(ExternalControl, EndsWhereNobodyListensOrTheAnswerIsNoProgram) {
  Pendant alone;
  { const TcpListener gone = std::move(alone.host); }
  ASSERT_TRUE(alone.controller.play_loaded());
  alone.run(0.5);
  EXPECT_THAT(alone.texts, HasSubstr("nobody listens"));
  EXPECT_FALSE(alone.controller.program_running());

  Pendant nonsense;
  ASSERT_TRUE(nonsense.controller.play_loaded());
  nonsense.answer("x = = 1\n# NODE_CONTROL_LOOP_ENDS\n");
  EXPECT_THAT(nonsense.exceptions, HasSubstr("syntax_error"));
  EXPECT_FALSE(nonsense.controller.program_running());

  Pendant silent;
  ASSERT_TRUE(silent.controller.play_loaded());
  silent.run(6.0);
  EXPECT_THAT(silent.texts, HasSubstr("no program came"));
  EXPECT_FALSE(silent.controller.program_running());
}

}  // namespace
}  // namespace stonestack::emulators
