// What a control step of the simulated controller may cost: a share of one quota for every thread.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "script_bench.hpp"
#include "stonestack/core/error.hpp"
#include "urscript/script_collector.hpp"

namespace stonestack::emulators {
namespace {

using ::testing::HasSubstr;

/// `count` threads run `line` for ever and count their turns in register 0; one more counts control steps
/// in 1.
std::string busy(int count, const std::string& line, int elements = 1) {
  std::string list = "1";
  for (int i = 1; i < elements; ++i) list += ",1";
  return concat(
      "def busy():\n global l = [", list, "]\n global n = 0\n thread t():\n  while True:\n   ", line,
      "\n   n = n + 1\n   write_output_integer_register(0, n)\n  end\n end\n i = 0\n while i < ", count,
      ":\n  run t()\n  i = i + 1\n end\n k = 0\n while True:\n  sync()\n  k = k + 1\n"
      "  write_output_integer_register(1, k)\n end\nend\n");
}

/// Turns of the busy threads in 50 control steps, and steps that the waiting one has seen.
std::pair<int, int> turns(const std::string& script) {
  ScriptBench bench;
  bench.controller.run_script(script);
  bench.run(50 * bench.controller.period());
  EXPECT_EQ(bench.exceptions, "");
  const auto& out = bench.controller.registers.out_int;
  return {out[0], out[1]};
}

TEST(UrScriptEffort, ManyThreadsTakeNoMoreThanOne) {
  const auto [one, seen_by_one] = turns(busy(1, "x = 1"));
  const auto [many, seen_by_many] = turns(busy(60, "x = 1"));
  EXPECT_GT(one, 1000);
  EXPECT_LT(many, 1.1 * one);
  EXPECT_GT(many, 0.3 * one) << "some are lost where two threads count at once";
  EXPECT_GT(seen_by_one, 45) << "who waits goes on beside it, step by step";
  EXPECT_GT(seen_by_many, 45);
}

TEST(UrScriptEffort, CopiesCount) {
  const int plain = turns(busy(60, "x = 1")).first;
  const auto [copies, seen] = turns(busy(60, "x = l", 1000));
  EXPECT_LT(copies, plain / 20);
  EXPECT_GT(copies, 0);
  EXPECT_GT(seen, 45);
  EXPECT_LT(turns(busy(60, "x = l * l", 1000)).first, plain / 50);
  EXPECT_LT(turns(busy(60, "x = to_str(l)", 1000)).first, plain / 50);
  EXPECT_LT(turns(busy(60, "x = str_cat(\"" + std::string(60000, 'x') + "\", \"\")")).first, plain / 50);
}

TEST(UrScriptEffort, TimeBeyondAStepIsPaidBack) {
  // One addition of such lists takes more than a step has.
  const auto [sums, seen] = turns(busy(1, "x = l + l", 10000));
  EXPECT_GT(sums, 5);
  EXPECT_LT(sums, 40);
  EXPECT_GT(seen, 10) << "those that wait have their turns in between";
}

TEST(UrScriptEffort, SlowFunctionsCount) {
  const int plain = turns(busy(60, "x = 1")).first;
  EXPECT_LT(turns(busy(60, "x = get_inverse_kin(get_actual_tcp_pose())")).first, plain / 5);
  EXPECT_LE(turns(busy(60, "x = socket_open(\"10.0.0.1\", 9)")).first, 50) << "one connection a step";
}

TEST(UrScriptEffort, EndlessThreadsAreReportedWithinSeconds) {
  for (const auto* line : {"x = 1", "x = l", "x = l * l", "x = get_inverse_kin(get_actual_tcp_pose())"}) {
    ScriptBench bench;
    bench.output(busy(60, line, 1000), 2.0);
    EXPECT_THAT(bench.exceptions, HasSubstr("Infinite loop detected")) << line;
    EXPECT_FALSE(bench.controller.program_running()) << line;
  }
}

TEST(UrScriptEffort, SecondaryProgramsShareTheStep) {
  const auto turns_beside = [](int secondaries) {
    ScriptBench bench;
    for (int i = 0; i < secondaries; ++i)
      bench.controller.run_script(concat("sec s", i, "():\n n = 0\n while True:\n  n = n + 1\n",
                                         "  write_output_integer_register(", i + 2, ", n)\n end\nend\n"));
    bench.controller.run_script(busy(2, "x = 1"));
    bench.run(50 * bench.controller.period());
    int all = bench.controller.registers.out_int[0];
    for (int i = 0; i < secondaries; ++i) {
      EXPECT_GT(bench.controller.registers.out_int[static_cast<std::size_t>(i) + 2], 0);
      all += bench.controller.registers.out_int[static_cast<std::size_t>(i) + 2];
    }
    return std::pair(all, bench.controller.registers.out_int[0]);
  };
  const auto [alone, main_alone] = turns_beside(0);
  const auto [together, main_beside] = turns_beside(8);
  EXPECT_LT(together, 2 * alone);
  EXPECT_GT(main_beside, main_alone / 20);
}

std::string repeated(const std::string& piece, std::size_t times) {
  std::string text;
  text.reserve(piece.size() * times);
  for (std::size_t i = 0; i < times; ++i) text += piece;
  return text;
}

/// Reply of the controller to a script that it cannot compile.
std::string complaint(const std::string& script) {
  ScriptBench bench;
  bench.controller.run_script(script);
  bench.run(2 * bench.controller.period());
  return bench.exceptions;
}

// Each of these took the square of its length: minutes, in which the controller made no step.
TEST(UrScriptEffort, LongScriptsCompileInTimeThatGrowsWithTheirLength) {
  EXPECT_EQ(complaint("def lines():\n" + repeated("a=1\n", 120'000) + "end\n"), "");
  std::string functions = "def many():\n";
  for (int i = 0; i < 20'000; ++i) functions += concat("def f", i, "():\nend\n");
  EXPECT_EQ(complaint(functions + repeated("f0()\n", 60'000) + "end\n"), "");
  EXPECT_EQ(complaint("def both():\ndef f():\n return 1\nend\ndef g():\n def f():\n  return 2\n end\n"
                      " return f()\nend\nif g() != 2 or f() != 1:\n x = [1][9]\nend\nend\n"),
            "")
      << "the nearest function of a name counts";
}

TEST(UrScriptEffort, TooLongOrTooDeepProgramsAreReported) {
  EXPECT_THAT(complaint("def tokens():\n a = [" + repeated("1,", 300'000) + "1]\nend\n"),
              HasSubstr("script too long: more than 500000 words, numbers and signs"));
  EXPECT_THAT(complaint("def longer():\n" + repeated("#\n", 2'100'000) + "end\n"),
              HasSubstr("script too long: more than 4000000 characters"));
  for (const char* open : {"(", "[", "f(", "-(", "a["})
    EXPECT_THAT(complaint("def deep():\n a = " + repeated(open, 100'000) + "\nend\n"),
                HasSubstr("syntax_error_on_line:2:"));
  EXPECT_THAT(complaint("def deep():\n" + repeated("if True:\n", 50'000) + "end\n"),
              HasSubstr("syntax_error"));
  EXPECT_THAT(complaint(repeated("def deep():\n", 50'000)), HasSubstr("syntax_error"));
}

TEST(UrScriptEffort, AComplaintQuotesOnlyTheBeginningOfALongLine) {
  EXPECT_LT(complaint("def wide():\n a = )" + repeated("x", 3'000'000) + "\nend\n").size(), 1000u);
  EXPECT_LT(complaint("def wide():\n " + repeated("x", 3'000'000) + "()\nend\n").size(), 1000u);
}

}  // namespace
}  // namespace stonestack::emulators
