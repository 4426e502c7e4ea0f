// Arguments that a controller refuses: numbers that are none, and values out of range.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "script_bench.hpp"

namespace stonestack::emulators {
namespace {

using ::testing::HasSubstr;

/// Reply of the controller to a line; `nan` and `inf` are numbers there, `q` where the arm is.
std::string error(const std::string& line, const std::string& version = "3.15.8.106339") {
  ScriptBench bench(version);
  bench.output(
      "def a():\n  inf = 1e308 * 1e308\n  nan = inf - inf\n  q = get_actual_joint_positions()\n"
      "  here = get_actual_tcp_pose()\n  " +
      line + "\nend\n");
  return bench.exceptions;
}

TEST(UrScriptRanges, NoVectorHoldsNanOrInfinity) {
  for (const std::string line :
       {"set_payload(1, [nan, 0, 0])", "set_payload_cog([0, inf, 0])", "set_gravity([0, 0, nan])",
        "set_target_payload(1, [0, 0, 0], [nan, 0, 0, 0, 0, 0])", "movej([nan, 0, 0, 0, 0, 0])",
        "movel(p[inf, 0, 0, 0, 0, 0])", "servoj([0, 0, 0, 0, 0, nan])", "speedl([0, 0, nan, 0, 0, 0], 1)",
        "speedj([0, 0, inf, 0, 0, 0], 1)", "set_tcp(p[0, 0, nan, 0, 0, 0])", "x = rpy2rotvec([nan, 0, 0])",
        "force_mode(here, [0, 0, 1, 0, 0, 0], [0, 0, nan, 0, 0, 0], 2, [1, 1, 1, 1, 1, 1])",
        "x = interpolate_pose(here, here, nan)", "movej(q, r=nan)", "movel(here, r=inf)"})
    EXPECT_THAT(error(line), HasSubstr("not finite")) << line;
  EXPECT_THAT(error("x = floor(nan)"), HasSubstr("out of range"));
}

TEST(UrScriptRanges, PayloadsAreWhatTheRobotCarries) {
  for (const std::string line : {"set_payload_mass(1e9)", "set_payload_mass(-5)", "set_payload_mass(nan)",
                                 "set_payload(nan)", "set_payload(-1)"})
    EXPECT_THAT(error(line), HasSubstr("this robot carries 10 kg")) << line;
  EXPECT_EQ(error("set_payload_mass(3.5)"), "");
}

TEST(UrScriptRanges, AnalogPortsAreThoseOfTheManual) {
  EXPECT_THAT(error("set_analog_inputrange(4, 0)"), HasSubstr("there is no analog port 4"));
  EXPECT_THAT(error("set_analog_inputrange(-1, 0)"), HasSubstr("there is no analog port -1"));
  EXPECT_THAT(error("set_analog_inputrange(1, 1)"), HasSubstr("no range 1"));
  EXPECT_THAT(error("set_analog_inputrange(2, 3)"), HasSubstr("no range 3"));
  EXPECT_EQ(error("set_analog_inputrange(2, 1)"), "");
  EXPECT_THAT(error("set_analog_outputdomain(2, 0)"), HasSubstr("there is no analog port 2"));
  EXPECT_THAT(error("set_analog_outputdomain(0, 2)"), HasSubstr("0 (mA) or 1 (V)"));
  EXPECT_THAT(error("set_runstate_outputs([18])"), HasSubstr("there is no pin 18"));
  EXPECT_THAT(error("set_runstate_outputs(1)"), HasSubstr("as a list"));
}

TEST(UrScriptRanges, MotionsEnd) {
  for (const std::string line : {"movej(q, t=inf)", "movel(here, t=nan)",
                                 "speedj([0, 0, 0, 0, 0, 0], 1, inf)", "speedl([0, 0, 0, 0, 0, 0], 1, nan)"})
    EXPECT_THAT(error(line), HasSubstr("not finite")) << line;
  for (const std::string line : {"movej(q, t=1e300)", "movej(q, t=-1)", "servoj(q, t=0)", "servoj(q, t=inf)"})
    EXPECT_THAT(error(line), HasSubstr("a time goes from")) << line;
  EXPECT_EQ(error("movej(q, t=0.1)"), "");
}

TEST(UrScriptRanges, ServojAndForceModeKeepToTheManual) {
  EXPECT_THAT(error("servoj(q, lookahead_time=99)"),
              HasSubstr("lookahead_time goes from 0.03 to 0.2, got 99"));
  EXPECT_THAT(error("servoj(q, lookahead_time=0.02)"), HasSubstr("lookahead_time"));
  EXPECT_THAT(error("servoj(q, gain=1e9)"), HasSubstr("gain goes from 100 to 2000"));
  EXPECT_THAT(error("servoj(q, gain=nan)"), HasSubstr("gain"));
  EXPECT_EQ(error("servoj(q, t=0.008, lookahead_time=0.03, gain=2000)"), "");
  EXPECT_EQ(error("servoj(q, t=0.008, lookahead_time=0.2, gain=100)"), "");
  EXPECT_THAT(error("force_mode_set_damping(1.5)"), HasSubstr("damping goes from 0 to 1"));
  EXPECT_THAT(error("force_mode_set_gain_scaling(3)", "5.12.2.1101534"),
              HasSubstr("scaling goes from 0 to 2"));
}

}  // namespace
}  // namespace stonestack::emulators
