// Scripts on the simulated controller: threads, registers, versions, errors with their line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "script_bench.hpp"

namespace stonestack::emulators {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(UrScript, TheStepIsThatOfTheControlRate) {
  EXPECT_EQ(ScriptBench().value("get_steptime()"), "0.008");
  EXPECT_EQ(ScriptBench("5.12.2.1101534").value("get_steptime()"), "0.002");
}

TEST(UrScript, Kinematics) {
  ScriptBench bench;
  EXPECT_EQ(bench.output("def k():\n"
                         "  q = get_inverse_kin(get_forward_kin(), get_actual_joint_positions())\n"
                         "  textmsg(norm(q - get_actual_joint_positions()) < 1e-6)\nend\n"),
            "True");
  EXPECT_EQ(bench.value("get_inverse_kin_has_solution(p[5,0,0,0,0,0])"), "False");
  bench.value("get_inverse_kin(p[5,0,0,0,0,0])");
  EXPECT_THAT(bench.exceptions, HasSubstr("unable to find an inverse kinematics solution"));
}

TEST(UrScript, ThreadsTakeTurnsAStepAtATime) {
  ScriptBench bench;
  EXPECT_EQ(bench.output("def threads():\n"
                         "  global n = 0\n"
                         "  thread count():\n"
                         "    while True:\n"
                         "      n = n + 1\n"
                         "      sync()\n"
                         "    end\n"
                         "  end\n"
                         "  thread brief():\n"
                         "    sleep(0.1)\n"
                         "    textmsg(\"brief done\")\n"
                         "  end\n"
                         "  none = 0\n"
                         "  kill none\n"
                         "  counter = run count()\n"
                         "  join run brief()\n"
                         "  kill counter\n"
                         "  textmsg(n > 10 and n < 16)\n"
                         "  last = n\n"
                         "  sleep(0.1)\n"
                         "  textmsg(n == last)\n"
                         "end\n"),
            "brief done|True|True");
}

TEST(UrScript, CriticalSectionsAreNotInterrupted) {
  // Two steps' worth of computing: outside a critical section the other thread sees it half done, inside not.
  const auto seen = [](const std::string& enter, const std::string& leave) {
    ScriptBench bench;
    return bench.output(
        "def sections():\n"
        "  global half = False\n"
        "  global seen = False\n"
        "  thread other():\n"
        "    while True:\n"
        "      seen = seen or half\n"
        "      sync()\n"
        "    end\n"
        "  end\n"
        "  handle = run other()\n"
        "  sync()\n" +
        enter +
        "  half = True\n"
        "  n = 0\n"
        "  while n < 5000:\n"
        "    n = n + 1\n"
        "  end\n"
        "  half = False\n" +
        leave +
        "  sync()\n"
        "  textmsg(seen)\n"
        "end\n");
  };
  EXPECT_EQ(seen("", ""), "True");
  EXPECT_EQ(seen("  enter_critical\n", "  exit_critical\n"), "False");
}

TEST(UrScript, WaitingInACriticalSectionLetsTheOthersIn) {
  // As in UR's client library, where the main thread joins a thread that has critical sections of its own.
  ScriptBench bench;
  EXPECT_EQ(bench.output("def joining():\n"
                         "  global going = True\n"
                         "  thread other():\n"
                         "    while going:\n"
                         "      enter_critical\n"
                         "      sync()\n"
                         "      exit_critical\n"
                         "    end\n"
                         "    textmsg(\"other over\")\n"
                         "  end\n"
                         "  handle = run other()\n"
                         "  sleep(0.05)\n"
                         "  enter_critical\n"
                         "  going = False\n"
                         "  join handle\n"
                         "  exit_critical\n"
                         "  textmsg(\"joined\")\n"
                         "end\n"),
            "other over|joined");
}

TEST(UrScript, RegistersAreSharedWithRtde) {
  ScriptBench bench;
  bench.controller.registers.in_int[24] = -7;
  bench.controller.registers.in_double[3] = 0.25;
  bench.controller.registers.in_bit[64] = true;
  EXPECT_EQ(bench.value("[read_input_integer_register(24), read_input_float_register(3), "
                        "read_input_boolean_register(64)]"),
            "[-7,0.25,True]");
  bench.output(
      "def w():\n write_output_integer_register(24, 42)\n write_output_float_register(1, 1.5)\n"
      " write_output_boolean_register(127, True)\nend\n");
  EXPECT_EQ(bench.controller.registers.out_int[24], 42);
  EXPECT_EQ(bench.controller.registers.out_double[1], 1.5);
  EXPECT_TRUE(bench.controller.registers.out_bit[127]);
  bench.value("read_input_integer_register(48)");
  EXPECT_THAT(bench.exceptions, HasSubstr("there is no register 48"));
  ScriptBench old("3.5.4.10845");
  old.value("read_input_integer_register(24)");
  EXPECT_THAT(old.exceptions, HasSubstr("there is no register 24")) << "upper registers came with 3.9";
}

TEST(UrScript, SyntaxErrorsNameTheirLine) {
  const auto error = [](const std::string& source) {
    ScriptBench bench;
    bench.output(source);
    EXPECT_EQ(bench.keys, "") << "nothing starts";
    return bench.exceptions;
  };
  EXPECT_EQ(error("def a():\n  textmsg(\"log \", get_actual_tcp_pose()\nend\n"),
            "3,1,syntax_error_on_line:3:end:");
  EXPECT_EQ(error("def a():\n  x = 1\n  if x == 1\n    x = 2\n  end\nend\n"),
            "3,12,syntax_error_on_line:3:  if x == 1:");
  EXPECT_THAT(error("def a():\n  x = = 1\nend\n"), StartsWith("2,7,syntax_error_on_line:2:"));
  EXPECT_THAT(error("def a():\n  s = \"open\n  y = 2\nend\n"), StartsWith("2,7,"));
  EXPECT_THAT(error("def a():\n  p[1,2,3]\nend\n"), StartsWith("2,3,"));
  EXPECT_THAT(error("def a():\n  break\nend\n"), StartsWith("2,3,"));
  EXPECT_THAT(error("def a():\n  x = 1 ? 2\nend\n"), StartsWith("2,9,"));
  EXPECT_THAT(error("def a():\n  while True:\n    sync()\nend\n"), HasSubstr("syntax_error_on_line:"));
  EXPECT_THAT(error("def 1():\nend\n"), StartsWith("1,5,"));
  EXPECT_THAT(error("def a():\n x = " + std::string(500, '(') + "1" + std::string(500, ')') + "\nend\n"),
              StartsWith("2,"))
      << "nested too deep";
}

TEST(UrScript, UnknownNamesAreFoundBeforeAnythingRuns) {
  ScriptBench bench;
  bench.output("def illegal_fun():\n  calldoesntexist()\nend");
  EXPECT_EQ(bench.exceptions, "2,3,compile_error_name_not_found:calldoesntexist:");
  bench.output("def a():\n  textmsg(\"no\")\n  x = y + 1\nend\n");
  EXPECT_EQ(bench.exceptions, "3,7,compile_error_name_not_found:y:");
  EXPECT_EQ(bench.keys, "");
}

TEST(UrScript, FunctionsComeWithVersions) {
  const auto answer = [](const std::string& version, const std::string& call) {
    ScriptBench bench(version);
    bench.output("def a():\n  " + call + "\nend\n");
    return bench.exceptions;
  };
  EXPECT_EQ(answer("3.5.4.10845", "protective_stop()"), "2,3,compile_error_name_not_found:protective_stop:");
  EXPECT_EQ(answer("3.5.4.10845", "force_mode_set_gain_scaling(1)"),
            "2,3,compile_error_name_not_found:force_mode_set_gain_scaling:");
  EXPECT_EQ(answer("3.15.8.106339", "force_mode_set_gain_scaling(1)"),
            "2,3,compile_error_name_not_found:force_mode_set_gain_scaling:")
      << "no CB3 has it";
  EXPECT_EQ(answer("5.12.2.1101534", "force_mode_set_gain_scaling(1)"), "");
}

TEST(UrScript, RunTimeErrorsEndTheProgramWithTheirLine) {
  ScriptBench bench;
  bench.output("def a():\n  l = [1]\n\n  textmsg(l[3])\nend\n");
  EXPECT_THAT(bench.exceptions, StartsWith("4,"));
  EXPECT_THAT(bench.exceptions, HasSubstr("Index out of bounds"));
  EXPECT_EQ(bench.keys, "PROGRAM_XXX_STARTED:a|PROGRAM_XXX_STOPPED:a|");
  const auto error = [&](const std::string& line) {
    bench.output("def a():\n  " + line + "\nend\n");
    return bench.exceptions;
  };
  EXPECT_THAT(error("x = 1 / 0"), HasSubstr("Division by zero"));
  EXPECT_THAT(error("x = \"a\" + 1"), HasSubstr("Type error"));
  EXPECT_THAT(error("movej([1,2,3])"), HasSubstr("Type error"));
  EXPECT_THAT(error("movej(get_actual_joint_positions(), v=-1)"), HasSubstr("positive"));
  EXPECT_THAT(error("movej(q=[0,0,0,0,0,0], speed=1)"), HasSubstr("wrong arguments for movej"));
  EXPECT_THAT(error("sleep()"), HasSubstr("wrong arguments for sleep"));
  EXPECT_THAT(error("set_payload(11)"), HasSubstr("this robot carries 10 kg"));
  EXPECT_THAT(error("x = sqrt(-1)"), HasSubstr("Value error"));
  EXPECT_THAT(error("rtde_set_watchdog(\"nothing\", 10)"), HasSubstr("no RTDE input"));
}

TEST(UrScript, EndlessLoopsAndRecursionAreErrors) {
  ScriptBench bench;
  bench.output("def a():\n  x = 0\n  while True:\n    x = x + 1\n  end\nend\n");
  EXPECT_THAT(bench.exceptions, HasSubstr("Infinite loop detected"));
  EXPECT_THAT(bench.exceptions, ::testing::AnyOf(StartsWith("3,"), StartsWith("4,")));
  bench.output("def a():\n  def f(x):\n    return f(x + 1)\n  end\n  f(0)\nend\n");
  EXPECT_THAT(bench.exceptions, HasSubstr("Too many nested calls"));
  bench.output("def a():\n  l = [1]\n  while True:\n    l = [l, l]\n  end\nend\n");
  EXPECT_THAT(bench.exceptions, ::testing::AnyOf(HasSubstr("too many elements"), HasSubstr("too deep")));
  bench.output("def a():\n  s = \"ab\"\n  while True:\n    s = str_cat(s, s)\n  end\nend\n");
  EXPECT_THAT(bench.exceptions, HasSubstr("too many characters"));
  bench.output("def a():\n  thread t():\n    sleep(9)\n  end\n  while True:\n    run t()\n  end\nend\n");
  EXPECT_THAT(bench.exceptions, HasSubstr("Too many threads"));
  // A loop that lets time pass is none, however long it runs.
  bench.output("def a():\n  while True:\n    sync()\n  end\nend\n", 3.0);
  EXPECT_EQ(bench.exceptions, "");
  EXPECT_TRUE(bench.controller.program_running());
}

TEST(UrScript, SecondaryProgramsRunBesideAndMayNotMove) {
  ScriptBench bench;
  bench.controller.run_script("def main():\n  sleep(0.5)\n  textmsg(\"main\")\nend\n");
  bench.run(0.1);
  bench.controller.run_script("sec aside():\n  set_standard_digital_out(2, True)\nend\n");
  bench.run(0.1);
  EXPECT_EQ(bench.controller.io.digital_out, 4U);
  bench.controller.run_script("sec moves():\n  movej([0,0,0,0,0,0])\nend\n");
  bench.run(0.1);
  EXPECT_THAT(bench.exceptions, HasSubstr("SECONDARY_PROGRAM_EXCEPTION_XXX"));
  bench.run_to_end();
  EXPECT_EQ(bench.texts, "main");
  EXPECT_EQ(bench.keys, "PROGRAM_XXX_STARTED:main|PROGRAM_XXX_STOPPED:main|");
}

TEST(UrScript, ANewProgramKillsTheRunningOneButABrokenOneDoesNot) {
  ScriptBench bench;
  bench.controller.run_script("def first():\n  sleep(10)\nend\n");
  bench.run(0.1);
  bench.controller.run_script("def broken(:\nend\n");
  bench.run(0.1);
  EXPECT_TRUE(bench.controller.program_running());
  bench.controller.run_script("def second():\n  textmsg(\"two\")\nend\n");
  bench.run(0.1);
  EXPECT_EQ(bench.keys,
            "PROGRAM_XXX_STARTED:first|PROGRAM_XXX_STOPPED:first|PROGRAM_XXX_STARTED:second|"
            "PROGRAM_XXX_STOPPED:second|");
}

}  // namespace
}  // namespace stonestack::emulators
