#include "hardware/ur/ur_arm.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "hardware/fake_ur.hpp"
#include "hardware/safety_state.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::hardware {
namespace {

using Status = MotionResult::Status;
using State = FakeUr::State;
using testing::HasSubstr;

const RobotModel& arm_model() {
  static const RobotModel robot = read_robot(STONESTACK_SOURCE_DIR "/data/robots/ur10.urdf");
  return robot;
}

JointTrajectory small_arm_move() {
  JointTrajectory move;
  move.time = {0.0, 0.5};
  move.q = {Joints::Zero(), Joints::Constant(0.05)};  // 1.2 rad/s^2
  move.qd = {Joints::Zero(), Joints::Zero()};
  return move;
}

bool is_stop(const std::string& script) {
  return script.find("servoj") == std::string::npos;
}

/// Runs a program for some states and ends it; stops end at once.
void obey(State& state, const std::string& script, int run, ScriptEnd end = ScriptEnd::kDone,
          long states = 30) {
  state.later.clear();
  state.set_run(run);
  state.set_end(ScriptEnd::kRunning);
  state.set_running(true);
  if (is_stop(script)) end = ScriptEnd::kDone;
  state.after(is_stop(script) ? 2 : states, [end, script](State& later) {
    later.set_running(false);
    later.set_end(end);
    if (!is_stop(script)) later.set("actual_q", std::array<double, 6>{0.1, 0.1, 0.1, 0.1, 0.1, 0.1});
  });
}

std::string key_exception(int line, const std::string& text) {
  PrimaryMessage message;
  message.kind = PrimaryMessage::Kind::kRuntimeException;
  message.line = line;
  message.text = text;
  return encode(message);
}

std::string read_only() {
  PrimaryMessage message;
  message.kind = PrimaryMessage::Kind::kError;
  message.code = 210;
  return encode(message);
}

/// The arm, its controller, and what the controller does with scripts.
struct ArmBench {
  explicit ArmBench(FakeUr::OnScript on_script, UrVersion version = {3, 15, 8, 106339})
      : robot(std::move(on_script), version), arm(arm_model(), robot.options(), Pose::Identity(), tool()) {}
  static Pose tool() { return Pose(Eigen::Translation3d(0, 0, 0.264)); }
  FakeUr robot;
  UrArm arm;
};

TEST(UrArm, FollowsToTheEnd) {
  ArmBench bench([](State& s, const std::string& script, int run) { obey(s, script, run); });
  const ArmState before = bench.arm.state();
  EXPECT_TRUE(before.can_move);
  EXPECT_EQ(before.speed_scaling, 1.0);
  EXPECT_GT(before.device_time, 100.0);
  const MotionResult moved = bench.arm.follow(small_arm_move());
  EXPECT_EQ(moved.status, Status::kDone) << moved.reason;
  EXPECT_NEAR(moved.q[5], 0.1, 1e-12);
  EXPECT_THAT(bench.robot.scripts(), HasSubstr("stk_to(1, 0.5"));
  EXPECT_EQ(bench.robot.count("def stonestack_1()"), 1);
  EXPECT_EQ(bench.robot.count("set_payload"), 0) << "the payload on the flange is unknown";
}

TEST(UrArm, EndsOnlyWithRunIdAndNoProgramAndEndState) {
  std::atomic<bool> ended{false};
  ArmBench bench([&ended](State& s, const std::string&, int run) {
    s.set_run(run);
    s.set_end(ScriptEnd::kDone);  // written, but the program still runs
    s.set_running(true);
    s.after(60, [](State& later) {
      later.set_end(ScriptEnd::kRunning);
      later.set_running(false);  // over, but no end state
    });
    s.after(70, [&ended](State& later) {
      later.set_end(ScriptEnd::kDone);
      ended = true;
    });
  });
  const MotionResult moved = bench.arm.follow(small_arm_move());
  EXPECT_EQ(moved.status, Status::kDone) << moved.reason;
  EXPECT_TRUE(ended);
}

TEST(UrArm, RefusesWhatDoesNotStartHereAndSendsNothing) {
  ArmBench bench([](State& s, const std::string& script, int run) { obey(s, script, run); });
  JointTrajectory far = small_arm_move();
  for (Joints& q : far.q) q[2] += 0.5;
  const MotionResult refused = bench.arm.follow(far);
  EXPECT_EQ(refused.status, Status::kRefused);
  EXPECT_THAT(refused.reason, HasSubstr("from where the arm is"));
  JointTrajectory nan = small_arm_move();
  nan.qd[0][0] = NAN;
  EXPECT_EQ(bench.arm.follow(nan).status, Status::kRefused);
  EXPECT_EQ(bench.robot.scripts(), "");
}

TEST(UrArm, SilentControllerIsInLocalControl) {
  ArmBench bench([](State&, const std::string&, int) {}, {5, 11, 0, 108249});
  bench.robot.set_remote(false);
  const MotionResult moved = bench.arm.follow(small_arm_move());
  EXPECT_EQ(moved.status, Status::kRefused);
  EXPECT_THAT(moved.reason, HasSubstr("switch to Remote"));
}

TEST(UrArm, ReconnectsOnceOnC210) {
  int scripts = 0;
  ArmBench bench([&scripts](State& s, const std::string& script, int run) {
    if (scripts++ == 0)
      s.to_send = read_only();
    else
      obey(s, script, run);
  });
  EXPECT_EQ(bench.arm.follow(small_arm_move()).status, Status::kDone);
  EXPECT_EQ(bench.robot.script_connections(), 2);
  ArmBench never([](State& s, const std::string&, int) { s.to_send = read_only(); });
  EXPECT_EQ(never.arm.follow(small_arm_move()).status, Status::kRefused);
  EXPECT_EQ(never.robot.count("servoj(q"), 2) << "sent twice, not more";
}

TEST(UrArm, AProgramThatFailsReportsTheLine) {
  ArmBench early([](State& s, const std::string&, int) { s.to_send = key_exception(6, "not found"); });
  const MotionResult refused = early.arm.follow(small_arm_move());
  EXPECT_EQ(refused.status, Status::kRefused);
  EXPECT_THAT(refused.reason, HasSubstr("line 6: not found: 'rtde_set_watchdog("));
  ArmBench late([](State& s, const std::string& script, int run) {
    obey(s, script, run);
    if (is_stop(script)) return;
    s.later.clear();
    s.to_send = key_exception(7, "no inverse kinematics");
    s.after(20, [](State& later) { later.set_running(false); });
  });
  const MotionResult died = late.arm.follow(small_arm_move());
  EXPECT_EQ(died.status, Status::kStopped);
  EXPECT_THAT(died.reason, HasSubstr("line 7: no inverse kinematics: 'set_tcp("));
  ArmBench killed([](State& s, const std::string& script, int run) {
    obey(s, script, run);
    s.later.clear();
    s.after(20, [](State& later) { later.set_running(false); });
  });
  EXPECT_THAT(killed.arm.follow(small_arm_move()).reason, HasSubstr("was killed"));
}

TEST(UrArm, AfterAProtectiveStopNothingMovesUntilRearmed) {
  ArmBench bench([](State& s, const std::string& script, int run) {
    obey(s, script, run);
    if (is_stop(script)) return;
    s.after(10, [](State& later) {
      later.set("safety_status", std::int32_t{3});
      later.set("safety_status_bits", std::uint32_t{0x404});
      later.set_running(false);
      later.later.clear();
    });
  });
  const MotionResult stopped = bench.arm.follow(small_arm_move());
  EXPECT_EQ(stopped.status, Status::kStopped);
  EXPECT_THAT(stopped.reason, HasSubstr("protective stop (safety 3, bits 0x404)"));
  EXPECT_FALSE(bench.arm.state().can_move);
  EXPECT_THROW(bench.arm.rearm(), DeviceError);
  bench.robot.change([](State& s) {
    s.set("safety_status", std::int32_t{1});
    s.set("safety_status_bits", std::uint32_t{1});
    s.set_running(false);
  });
  MotionResult refused;
  EXPECT_TRUE(eventually([&] {  // the controller's state arrives a little later
    refused = bench.arm.follow(small_arm_move());
    return refused.reason.find("re-armed") != std::string::npos;
  })) << refused.reason;
  EXPECT_EQ(refused.status, Status::kRefused);
  EXPECT_THAT(refused.reason, HasSubstr("bits 0x404"));
  EXPECT_EQ(bench.robot.count("servoj(q"), 1);
  EXPECT_NO_THROW(bench.arm.rearm());
  EXPECT_TRUE(bench.arm.state().can_move);
}

TEST(UrArm, NothingMovesOnceTheSafetyConfigurationHasChanged) {
  FakeUr robot([](State& s, const std::string& script, int run) { obey(s, script, run); });
  robot.change([](State& s) { s.to_send = state_with_safety("57F4285B"); });
  UrArmOptions options = robot.options();
  options.safety_checksum = "57F4285B";
  UrArm arm(arm_model(), options, Pose::Identity(), ArmBench::tool());
  const MotionResult moved = arm.follow(small_arm_move());
  EXPECT_EQ(moved.status, Status::kDone) << moved.reason;
  robot.change([](State& s) { s.to_send = state_with_safety("00000001"); });
  ASSERT_TRUE(eventually([&] { return arm.safety_checksum() == 1U; }));
  const MotionResult refused = arm.follow(small_arm_move());
  EXPECT_EQ(refused.status, Status::kRefused);
  EXPECT_THAT(refused.reason, testing::AllOf(HasSubstr("00000001"), HasSubstr("57F4285B")));
  EXPECT_THROW(arm.set_payload(1.0, {0, 0, 0.1}), DeviceError);
  EXPECT_EQ(robot.count("def stonestack_2()"), 0);
}

TEST(UrArm, ASafetyChecksumCountsForItsConnectionOnly) {
  FakeUr robot([](State& s, const std::string& script, int run) { obey(s, script, run); });
  robot.change([](State& s) { s.to_send = state_with_safety("57F4285B"); });
  UrArmOptions options = robot.options();
  options.safety_checksum = "57F4285B";
  UrArm arm(arm_model(), options, Pose::Identity(), ArmBench::tool());
  robot.drop_scripts();
  robot.change([](State& s) { s.to_send = state_with_safety("00000001"); });
  std::this_thread::sleep_for(std::chrono::milliseconds(100));  // the arm has seen the connection end
  const MotionResult refused = arm.follow(small_arm_move());
  EXPECT_EQ(refused.status, Status::kRefused);
  EXPECT_THAT(refused.reason, testing::AllOf(HasSubstr("00000001"), HasSubstr("57F4285B")));
  EXPECT_EQ(robot.count("servoj(q"), 0);
  robot.change([](State& s) { s.to_send = state_with_safety("57F4285B"); });
  ASSERT_TRUE(eventually([&] { return arm.safety_checksum() == 0x57F4285BU; }));
  EXPECT_EQ(arm.follow(small_arm_move()).status, Status::kDone);
}

TEST(UrArm, ASafetyChecksumIsComparedOnTheConnectionThatReplacesAReadOnlyOne) {
  FakeUr robot([](State& s, const std::string&, int) { s.to_send = read_only(); });
  robot.change([](State& s) { s.to_send = state_with_safety("57F4285B"); });
  UrArmOptions options = robot.options();
  options.safety_checksum = "57F4285B";
  UrArm arm(arm_model(), options, Pose::Identity(), ArmBench::tool());
  std::thread other([&] {
    EXPECT_TRUE(eventually([&] { return robot.script_connections() == 2; }));
    robot.change([](State& s) { s.to_send = state_with_safety("00000001"); });
  });
  const MotionResult refused = arm.follow(small_arm_move());
  other.join();
  EXPECT_EQ(refused.status, Status::kRefused);
  EXPECT_THAT(refused.reason, HasSubstr("00000001"));
  EXPECT_EQ(robot.count("servoj(q"), 1);
}

TEST(UrArm, NotesAStopWhileNothingMoves) {
  ArmBench bench([](State& s, const std::string& script, int run) { obey(s, script, run); });
  bench.robot.change([](State& s) {
    s.set("safety_status", std::int32_t{7});
    s.set("safety_status_bits", std::uint32_t{0xC0});
  });
  ASSERT_TRUE(eventually([&] { return !bench.arm.state().can_move; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  bench.robot.change([](State& s) {
    s.set("safety_status", std::int32_t{1});
    s.set("safety_status_bits", std::uint32_t{1});
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  EXPECT_THAT(bench.arm.state().stop_reason, HasSubstr("emergency stop of the robot"));
}

TEST(UrArm, SliderAtZeroIsAPauseNotATimeOut) {
  const auto paused_for = [](long states) {
    return [states](State& s, const std::string& script, int run) {
      obey(s, script, run);
      if (is_stop(script)) return;
      s.later.clear();
      s.set("target_speed_fraction", 0.0);
      s.after(states, [script, run](State& later) {
        later.set("target_speed_fraction", 0.5);
        obey(later, script, run);
      });
    };
  };
  ArmBench bench(paused_for(600));  // 4.8 s of the controller's clock, allowed are 1.75 s
  const MotionResult moved = bench.arm.follow(small_arm_move());
  EXPECT_EQ(moved.status, Status::kDone) << moved.reason;
  ArmBench for_ever(paused_for(1000000));
  const MotionResult given_up = for_ever.arm.follow(small_arm_move());
  EXPECT_EQ(given_up.status, Status::kStopped);
  EXPECT_THAT(given_up.reason, HasSubstr("paused by the user"));
  EXPECT_TRUE(eventually([&] {
    return for_ever.robot.count("servoj(q") == 1 && for_ever.robot.count("def stonestack") == 2;
  })) << "the program is not left running";
}

/// A program that somebody pauses soon after its start, and `later` plays after so many states.
FakeUr::OnScript paused_soon(long later) {
  return [later](State& s, const std::string& script, int run) {
    obey(s, script, run);
    if (is_stop(script)) return;
    s.later.clear();
    s.after(10, [](State& now) { now.set_paused(); });
    s.after(later, [script, run](State& now) { obey(now, script, run); });
  };
}

TEST(UrArm, APausedProgramIsWaitedFor) {
  ArmBench bench(
      paused_soon(600));  // 0.6 s, and 4.8 s of the controller's clock: allowed are 0.1 s and 1.75 s
  const MotionResult moved = bench.arm.follow(small_arm_move());
  EXPECT_EQ(moved.status, Status::kDone) << moved.reason;
  EXPECT_EQ(bench.robot.count("def stonestack"), 1) << "no stop";
}

TEST(UrArm, APausedProgramIsStoppedAfterFiveMinutes) {
  FakeUr robot(paused_soon(1000000));
  robot.set_period(0.5);
  UrArmOptions options = robot.options();
  options.pause_limit = UrArmOptions{}.pause_limit;
  EXPECT_EQ(options.pause_limit, 300.0) << "as documented";
  options.time_slack = 1e5;
  UrArm arm(arm_model(), options, Pose::Identity(), ArmBench::tool());
  const double before = arm.state().device_time;
  const MotionResult given_up = arm.follow(small_arm_move());
  EXPECT_GE(arm.state().device_time - before, 300.0);
  EXPECT_EQ(given_up.status, Status::kStopped);
  EXPECT_THAT(given_up.reason, HasSubstr("paused by the user"));
  EXPECT_EQ(robot.count("def stonestack"), 2) << "the program does not stay there for somebody to play it";
}

TEST(UrArm, AnArmThatWasMovedInAPauseIsNotResumed) {
  ArmBench bench([](State& s, const std::string& script, int run) {
    paused_soon(1000000)(s, script, run);
    if (!is_stop(script))
      s.after(200, [](State& now) { now.set("actual_q", std::array<double, 6>{0, 0, 0.02, 0, 0, 0}); });
  });
  const MotionResult stopped = bench.arm.follow(small_arm_move());
  EXPECT_EQ(stopped.status, Status::kStopped);
  EXPECT_THAT(stopped.reason, HasSubstr("moved by 0.02 rad while the program was paused"));
  EXPECT_EQ(bench.robot.count("def stonestack"), 2) << "the paused program is ended";
}

TEST(UrArm, APausedProgramThatDoesNotObeyAStopLosesItsHeartbeat) {
  ArmBench bench([](State& s, const std::string& script, int run) {
    if (!is_stop(script)) paused_soon(1000000)(s, script, run);
  });
  const MotionResult given_up = bench.arm.follow(small_arm_move());
  EXPECT_THAT(given_up.reason, HasSubstr("paused by the user"));
  const auto beats = [&] { return bench.robot.rtde().requests(RtdeKind::kDataPackage).size(); };
  std::this_thread::sleep_for(std::chrono::milliseconds(100));  // packets in transit have arrived
  const auto before = beats();
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_EQ(beats(), before) << "the watchdog ends it when somebody plays it";
  EXPECT_THAT(bench.arm.follow(small_arm_move()).reason, HasSubstr("did not obey a stop"));
  EXPECT_THROW(bench.arm.rearm(), DeviceError) << "it is still there";
}

TEST(UrArm, ARunningProgramThatDoesNotObeyAStopLosesItsHeartbeat) {
  ArmBench bench([](State& s, const std::string& script, int run) {
    if (is_stop(script)) return;
    obey(s, script, run);
    s.later.clear();
  });
  const MotionResult given_up = bench.arm.follow(small_arm_move());
  EXPECT_EQ(given_up.status, Status::kStopped);
  EXPECT_THAT(given_up.reason, HasSubstr("not done after"));
  const auto beats = [&] { return bench.robot.rtde().requests(RtdeKind::kDataPackage).size(); };
  std::this_thread::sleep_for(std::chrono::milliseconds(100));  // packets in transit have arrived
  const auto before = beats();
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_EQ(beats(), before) << "the watchdog ends it";
  EXPECT_THAT(bench.arm.state().stop_reason, HasSubstr("did not obey a stop"));
  EXPECT_THROW(bench.arm.rearm(), DeviceError) << "it still runs";
}

TEST(UrArm, AStopThatAReadOnlyConnectionRefusesIsSentOnANewOne) {
  std::atomic<int> stops{0};
  ArmBench bench([&stops](State& s, const std::string& script, int run) {
    if (is_stop(script) && stops++ == 0) {
      s.to_send = read_only();
      return;
    }
    obey(s, script, run);
    if (!is_stop(script)) s.later.clear();
  });
  EXPECT_EQ(bench.arm.follow(small_arm_move()).status, Status::kStopped);
  EXPECT_EQ(stops, 2);
  EXPECT_EQ(bench.robot.script_connections(), 2);
  EXPECT_TRUE(bench.arm.state().can_move) << "the second stop was obeyed";
}

TEST(UrArm, AProgramThatStartsLateIsStoppedBeforeTheDashboardIsAsked) {
  FakeServer silent([](TcpStream& stream, int) {
    std::array<std::uint8_t, 64> bytes{};
    while (stream.read_some(bytes, Deadline::in(0.02)).status != IoStatus::kClosed) continue;
  });
  FakeUr robot([](State& s, const std::string& script, int run) {
    if (!is_stop(script)) return;  // starts when the stop is there, too
    s.after(50, [](State& later) {
      later.set_run(1);
      later.set_running(true);
    });
    s.after(150, [run](State& later) {
      later.set_run(run);
      later.set_running(false);
    });
  });
  UrArmOptions options = robot.options();
  options.dashboard_port = silent.port();
  UrArm arm(arm_model(), options, Pose::Identity(), ArmBench::tool());
  MotionResult moved;
  std::thread mover([&] { moved = arm.follow(small_arm_move()); });
  EXPECT_TRUE(eventually([&] { return robot.count("servoj(q") == 1; }));
  EXPECT_TRUE(eventually([&] { return robot.count("def stonestack") == 2; }, 2.0));
  mover.join();
  EXPECT_EQ(moved.status, Status::kStopped);
  EXPECT_THAT(moved.reason, HasSubstr("started late"));
  EXPECT_EQ(robot.count("def stonestack"), 2);
  EXPECT_EQ(silent.connections(), 0) << "it did start";
}

TEST(UrArm, AnotherClientsProgramIsPausedWhilePausingAndRunsWhileResuming) {
  ArmBench bench([](State& s, const std::string& script, int run) { obey(s, script, run); });
  for (const auto& [state, reason] : {std::pair(UrStatus::kPausing, "paused on the controller"),
                                      std::pair(UrStatus::kPaused, "paused on the controller"),
                                      std::pair(UrStatus::kResuming, "another program runs")}) {
    bench.robot.change([state = state](State& s) {
      s.set_paused();  // the bit of a running program is clear
      s.set("runtime_state", state);
    });
    EXPECT_TRUE(eventually([&, reason = std::string(reason)] {
      return bench.arm.follow(small_arm_move()).reason.find(reason) != std::string::npos;
    })) << state;
  }
}

TEST(UrArm, AnotherClientsPausedProgramIsNotReplaced) {
  ArmBench bench([](State& s, const std::string& script, int run) { obey(s, script, run); });
  bench.robot.change([](State& s) { s.set_paused(); });
  ASSERT_TRUE(eventually([&] {
    return bench.arm.follow(small_arm_move()).reason.find("paused on the controller") != std::string::npos;
  }));
}

TEST(UrArm, EveryEndButItsOwnSendsAStop) {
  const auto stops_after = [](const std::function<void(State&, const std::string&, int)>& program) {
    ArmBench bench([&](State& s, const std::string& script, int run) {
      obey(s, script, run);
      if (!is_stop(script)) program(s, script, run);
    });
    EXPECT_NE(bench.arm.follow(small_arm_move()).status, Status::kDone);
    return eventually([&] { return bench.robot.count("def stonestack") == 2; });
  };
  const auto soon = [](std::function<void(State&)> what) {
    return [what = std::move(what)](State& s, const std::string&, int) {
      s.later.clear();
      s.after(20, what);
    };
  };
  EXPECT_TRUE(stops_after(soon([](State& s) { s.set_running(false); }))) << "killed";
  EXPECT_TRUE(stops_after(soon([](State& s) { s.set_run(4711); }))) << "taken";
  EXPECT_TRUE(stops_after(soon([](State& s) { s.set("safety_status", std::int32_t{3}); }))) << "safety";
  EXPECT_TRUE(stops_after(soon([](State& s) {
    s.set_running(false);
    s.set_end(ScriptEnd::kFellBehind);
  }))) << "fell behind";
  EXPECT_TRUE(stops_after([](State& s, const std::string&, int) {
    s.to_send = key_exception(7, "no inverse kinematics");
    s.set_run(0);  // and it has not begun
    s.later.clear();
  })) << "died";
  EXPECT_TRUE(stops_after([](State& s, const std::string&, int) { s.later.clear(); })) << "not done in time";
}

TEST(UrArm, AProgramThatFellBehindIsAStop) {
  ArmBench bench(
      [](State& s, const std::string& script, int run) { obey(s, script, run, ScriptEnd::kFellBehind); });
  const MotionResult stopped = bench.arm.follow(small_arm_move());
  EXPECT_EQ(stopped.status, Status::kStopped);
  EXPECT_THAT(stopped.reason, HasSubstr("too far from its path"));
}

TEST(UrArm, AMotionThatNeverEndsIsStopped) {
  ArmBench bench([](State& s, const std::string& script, int run) {
    obey(s, script, run);
    if (!is_stop(script)) s.later.clear();
  });
  const MotionResult moved = bench.arm.follow(small_arm_move());
  EXPECT_EQ(moved.status, Status::kStopped);
  EXPECT_THAT(moved.reason, HasSubstr("not done after"));
  EXPECT_TRUE(eventually([&] { return bench.robot.count("def stonestack") == 2; }));
}

TEST(UrArm, StopFromAnotherThread) {
  ArmBench bench([](State& s, const std::string& script, int run) {
    obey(s, script, run, ScriptEnd::kDone, is_stop(script) ? 2 : 150);
  });
  std::thread stopper([&] {
    EXPECT_TRUE(eventually([&] { return bench.robot.count("servoj(q") == 1; }));
    bench.arm.stop();
  });
  const MotionResult moved = bench.arm.follow(small_arm_move());
  stopper.join();
  EXPECT_EQ(moved.status, Status::kStopped);
  EXPECT_THAT(moved.reason, HasSubstr("by command"));
  EXPECT_EQ(bench.robot.count("servoj(q"), 1);
  EXPECT_EQ(bench.arm.follow(small_arm_move()).status, Status::kDone) << "a new command moves again";
}

TEST(UrArm, AStopThatComesBeforeTheProgramIsSentKeepsItFromBeingSent) {
  ArmBench bench([](State& s, const std::string& script, int run) { obey(s, script, run); });
  JointTrajectory slow = small_arm_move();
  slow.time = {0.0, 20000.0};  // the gate takes every control step
  MotionResult moved;
  std::thread mover([&] { moved = bench.arm.follow(slow); });
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(bench.robot.count("servoj(q"), 0) << "the gate is done already";
  bench.arm.stop();
  mover.join();
  EXPECT_EQ(moved.status, Status::kStopped);
  EXPECT_THAT(moved.reason, HasSubstr("by command"));
  EXPECT_EQ(bench.robot.count("servoj(q"), 0);
}

TEST(UrArm, AStopWaitsForAProgramThatHasNotStartedYet) {
  std::atomic<bool> obeyed{false};
  ArmBench bench([&obeyed](State& s, const std::string& script, int run) {
    s.later.clear();
    if (!is_stop(script)) return;  // starts too late to be seen
    s.after(60, [&obeyed, run](State& later) {
      later.set_run(run);
      obeyed = true;
    });
  });
  MotionResult moved;
  std::thread mover([&] { moved = bench.arm.follow(small_arm_move()); });
  EXPECT_TRUE(eventually([&] { return bench.robot.count("servoj(q") == 1; }));
  bench.arm.stop();
  EXPECT_TRUE(obeyed) << "the arm stood because the program had not started";
  mover.join();
  EXPECT_EQ(moved.status, Status::kStopped);
}

TEST(UrArm, AStopThatIsNotObeyedIsAnError) {
  ArmBench bench([](State&, const std::string&, int) {});
  bench.robot.change([](State& s) { s.set("actual_qd", std::array<double, 6>{0.5, 0, 0, 0, 0, 0}); });
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
  EXPECT_THROW(bench.arm.stop(), DeviceError);
}

TEST(UrArm, AStopThatCannotBeSentLeavesTheArmToTheWatchdog) {
  ArmBench bench(
      [](State& s, const std::string& script, int run) { obey(s, script, run, ScriptEnd::kDone, 100000); });
  std::thread moving([&] { EXPECT_NE(bench.arm.follow(small_arm_move()).status, Status::kDone); });
  ASSERT_TRUE(eventually([&] { return bench.robot.count("servoj(q") == 1; }));
  bench.robot.close_scripts();
  bench.robot.change([](State& s) { s.set("actual_qd", std::array<double, 6>{0.5, 0, 0, 0, 0, 0}); });
  std::this_thread::sleep_for(std::chrono::milliseconds(100));  // the arm has seen the connection end
  EXPECT_THROW(bench.arm.stop(), DeviceError);
  moving.join();
  const auto beats = [&] { return bench.robot.rtde().requests(RtdeKind::kDataPackage).size(); };
  std::this_thread::sleep_for(std::chrono::milliseconds(100));  // packets in transit have arrived
  const auto before = beats();
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  EXPECT_EQ(beats(), before) << "a heartbeat keeps the program, and the arm, going";
  EXPECT_THAT(bench.arm.state().stop_reason, HasSubstr("could not send a stop"));
  EXPECT_THROW(bench.arm.rearm(), DeviceError) << "the program runs";
  bench.robot.change([](State& s) {
    s.later.clear();
    s.set_running(false);
  });
  EXPECT_TRUE(eventually([&] {
    try {
      bench.arm.rearm();
      return true;
    } catch (const DeviceError&) {
      return false;
    }
  }));
  EXPECT_TRUE(eventually([&] { return beats() > before; }));
}

TEST(UrArm, AnotherClientsProgram) {
  ArmBench taken([](State& s, const std::string& script, int run) {
    obey(s, script, run);
    if (is_stop(script)) return;
    s.later.clear();
    s.after(10, [](State& later) { later.set_run(4711); });
  });
  EXPECT_THAT(taken.arm.follow(small_arm_move()).reason, HasSubstr("another program"));
  ArmBench busy([](State& s, const std::string& script, int run) { obey(s, script, run); });
  busy.robot.change([](State& s) { s.set_running(true); });
  ASSERT_TRUE(eventually([&] { return busy.arm.follow(small_arm_move()).status == Status::kRefused; }));
}

TEST(UrArm, LosingTheLinkLosesTheMotion) {
  ArmBench bench(
      [](State& s, const std::string& script, int run) { obey(s, script, run, ScriptEnd::kDone, 2000); });
  std::thread cutter([&] {
    EXPECT_TRUE(eventually([&] { return bench.robot.count("servoj(q") == 1; }));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    bench.robot.drop_rtde();
  });
  const MotionResult moved = bench.arm.follow(small_arm_move());
  cutter.join();
  EXPECT_EQ(moved.status, Status::kLost) << moved.reason;
  EXPECT_TRUE(eventually([&] { return bench.robot.count("def stonestack") == 2; })) << "a stop was sent";
}

TEST(UrArm, AMotionWhoseLinkFallsSilentEndsWhereTheArmWasLastSeen) {
  ArmBench bench(
      [](State& s, const std::string& script, int run) { obey(s, script, run, ScriptEnd::kDone, 100000); });
  JointTrajectory slow = small_arm_move();
  slow.time = {0.0, 100.0};
  MotionResult moved;
  std::thread mover([&] { moved = bench.arm.follow(slow); });
  EXPECT_TRUE(eventually([&] { return bench.robot.count("servoj(q") == 1; }));
  bench.robot.change([](State& s) { s.set("actual_q", std::array<double, 6>{0.03, 0, 0, 0, 0, 0}); });
  EXPECT_TRUE(eventually([&] { return bench.arm.state().q[0] == 0.03; }));
  const MotionResult second = bench.arm.follow(slow);
  EXPECT_EQ(second.status, Status::kRefused);
  EXPECT_THAT(second.reason, HasSubstr("another motion"));
  EXPECT_EQ(second.q[0], 0.03);
  bench.robot.set_silent(true);
  mover.join();
  EXPECT_EQ(moved.status, Status::kLost);
  EXPECT_EQ(moved.q[0], 0.03);
  bench.robot.set_silent(false);
  std::string reason;
  EXPECT_TRUE(eventually([&] {
    try {
      reason = bench.arm.state().stop_reason;
      return !reason.empty();
    } catch (const DeviceError&) {  // the link is being set up anew
      return false;
    }
  }));
  EXPECT_THAT(reason, HasSubstr("whether a stop was obeyed is not known"));
}

TEST(UrArm, HeartbeatRises) {
  ArmBench bench([](State&, const std::string&, int) {});
  ASSERT_TRUE(eventually([&] { return bench.robot.rtde().requests(RtdeKind::kDataPackage).size() > 5; }));
  const std::vector<RtdeType> types = {RtdeType::kInt32, RtdeType::kInt32, RtdeType::kDouble,
                                       RtdeType::kDouble, RtdeType::kDouble};
  std::int32_t before = 0;
  for (const RtdePacket& packet : bench.robot.rtde().requests(RtdeKind::kDataPackage)) {
    const auto data = decode_data(packet, types, 2, false);
    ASSERT_TRUE(data);
    EXPECT_EQ(std::get<std::int32_t>(data->values[0]), before + 1);
    before = std::get<std::int32_t>(data->values[0]);
  }
}

/// Reads (1, 2, 3) N in F, a new sample every call until changed.
struct FakeSensor : ForceTorqueSensor {
  [[nodiscard]] Wrench read() override {
    if (broken) throw DeviceError("sensor", "reading is old", "look at the cable");
    if (!frozen) time += 0.01;
    return {{1, 2, 3}, Eigen::Vector3d::Zero(), time};
  }
  void zero() override {}
  double time = 0.0;
  bool frozen = false, broken = false;
};

GuardedMotion guarded() {
  GuardedMotion motion;
  motion.trajectory = small_arm_move();
  return motion;
}

TEST(UrArm, GuardedMotionStreamsTheForceInTheBaseFrame) {
  FakeUr robot([](State& s, const std::string& script, int run) {
    s.set("output_double_register_30", 6.5);
    obey(s, script, run, ScriptEnd::kContact);
  });
  FakeSensor sensor;
  Pose T_W_R = Pose::Identity();
  T_W_R.linear() = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  UrArm arm(arm_model(), robot.options(), T_W_R, ArmBench::tool(), &sensor);
  const MotionResult moved = arm.follow_guarded(guarded());
  EXPECT_EQ(moved.status, Status::kContact) << moved.reason;
  EXPECT_EQ(moved.force, 6.5);
  EXPECT_EQ(moved.mean_force, 6.5);
  // -z of W is -y of R here, and the controller's base is half a turn about z from R.
  EXPECT_THAT(robot.scripts(), HasSubstr("+ 1.000000000 * read_input_float_register(25)"));
  const Eigen::Vector3d expected = Eigen::Vector3d(-1, -1, 1).cwiseProduct(
      forward(arm_model(), Joints::Zero()).rotation() * Eigen::Vector3d(1, 2, 3));
  const std::vector<RtdeType> types = {RtdeType::kInt32, RtdeType::kInt32, RtdeType::kDouble,
                                       RtdeType::kDouble, RtdeType::kDouble};
  int fresh = 0, count = 0;
  for (const RtdePacket& packet : robot.rtde().requests(RtdeKind::kDataPackage)) {
    const auto data = decode_data(packet, types, 2, false);
    const int now = std::get<std::int32_t>(data->values[1]);
    if (now == count) continue;
    EXPECT_EQ(now, count + 1);
    count = now;
    if (++fresh > 5) continue;
    const Eigen::Vector3d force(std::get<double>(data->values[2]), std::get<double>(data->values[3]),
                                std::get<double>(data->values[4]));
    EXPECT_LT((force - expected).norm(), 1e-9);
  }
  EXPECT_GE(fresh, 5);
}

TEST(UrArm, GuardedEnds) {
  for (const auto& [end, status] : {std::pair{ScriptEnd::kNoContact, Status::kNoContact},
                                    std::pair{ScriptEnd::kStaleForce, Status::kStopped}}) {
    FakeUr robot([end = end](State& s, const std::string& script, int run) { obey(s, script, run, end); });
    FakeSensor sensor;
    UrArm arm(arm_model(), robot.options(), Pose::Identity(), ArmBench::tool(), &sensor);
    EXPECT_EQ(arm.follow_guarded(guarded()).status, status);
  }
}

TEST(UrArm, SilentOrBrokenSensor) {
  FakeUr robot(
      [](State& s, const std::string& script, int run) { obey(s, script, run, ScriptEnd::kStaleForce); });
  FakeSensor sensor;
  sensor.frozen = true;
  sensor.time = 1.0;
  UrArm arm(arm_model(), robot.options(), Pose::Identity(), ArmBench::tool(), &sensor);
  EXPECT_EQ(arm.follow_guarded(guarded()).status, Status::kStopped);
  const auto last = robot.rtde().requests(RtdeKind::kDataPackage).back();
  EXPECT_EQ(last.payload.substr(5, 4), hex("00 00 00 01")) << "one reading, one count";
  sensor.broken = true;
  robot.change([](State& s) { s.set("actual_q", std::array<double, 6>{}); });
  ASSERT_TRUE(eventually([&] { return arm.state().q.norm() == 0; }));
  const MotionResult lost = arm.follow_guarded(guarded());
  EXPECT_EQ(lost.status, Status::kLost);
  EXPECT_THAT(lost.reason, HasSubstr("reading is old"));
  ArmBench without([](State& s, const std::string& script, int run) { obey(s, script, run); });
  EXPECT_THAT(without.arm.follow_guarded(guarded()).reason, HasSubstr("needs a force-torque sensor"));
}

TEST(UrArm, PayloadIsSetAndReadBack) {
  ArmBench bench([](State& s, const std::string& script, int run) {
    obey(s, script, run);
    s.set("payload", 2.5);
    s.set("payload_cog", std::array<double, 3>{0, 0, 0.1});
    s.set("tcp_offset", std::array<double, 6>{0, 0, 0.264, 0, 0, 0});
  });
  bench.arm.set_payload(2.5, {0, 0, 0.1});
  EXPECT_EQ(bench.robot.count("set_payload(2.500000000, [0.000000000, 0.000000000, 0.100000000])"), 1);
  EXPECT_EQ(bench.arm.follow(small_arm_move()).status, Status::kDone);
  EXPECT_EQ(bench.robot.count("set_payload(2.500000000"), 2) << "every program sets it";
  EXPECT_THROW(bench.arm.set_payload(11.0, {0, 0, 0}), InvalidArgument);
  EXPECT_THROW(bench.arm.set_payload(NAN, {0, 0, 0}), InvalidArgument);
  try {
    bench.arm.set_payload(3.0, {0, 0, 0.1});
    FAIL();
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), HasSubstr("reads back a payload of 2.5 kg, not 3"));
  }
}

TEST(UrArm, ACentreOrATurnedToolThatIsReadBackOtherwiseIsAnError) {
  const auto problem_of = [](std::array<double, 3> centre, std::array<double, 6> tool) -> std::string {
    ArmBench bench([=](State& s, const std::string& script, int run) {
      obey(s, script, run);
      s.set("payload", 2.5);
      s.set("payload_cog", centre);
      s.set("tcp_offset", tool);
    });
    try {
      bench.arm.set_payload(2.5, {0, 0, 0.1});
    } catch (const DeviceError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(problem_of({0, 0, 0.1}, {0, 0, 0.264, 0, 0, 0}), "");
  EXPECT_THAT(problem_of({0, 0, 0.2}, {0, 0, 0.264, 0, 0, 0}),
              HasSubstr("payload's centre at (  0   0 0.2) m"));
  EXPECT_THAT(problem_of({0, 0, 0.1}, {0, 0, 0.264, 0, 0, 0.5}), HasSubstr("turned by (  0   0 0.5) rad"));
  EXPECT_EQ(problem_of({0, 0, 0.1}, {0, 0, 0.264, 0, 0, 2 * M_PI}), "") << "a whole turn is none";
}

TEST(UrArm, OldControllersUseTheLowerRegisters) {
  ArmBench bench([](State& s, const std::string& script, int run) { obey(s, script, run); }, {3, 8, 0, 0});
  EXPECT_EQ(bench.arm.follow(small_arm_move()).status, Status::kDone);
  EXPECT_THAT(bench.robot.scripts(), HasSubstr("rtde_set_watchdog(\"input_int_register_0\""));
}

TEST(UrArm, PolyScopeXIsRefused) {
  FakeUr robot([](State&, const std::string&, int) {}, {10, 7, 0, 0});
  try {
    const UrArm arm(arm_model(), robot.options(), Pose::Identity(), ArmBench::tool());
    FAIL();
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), HasSubstr("UR controller at 127.0.0.1: PolyScope X 10.7.0.0"));
  }
}

TEST(UrArm, NamesEveryStopOfTheSafetySystem) {
  const auto stop = [](int safety, std::uint32_t bits) {
    UrStatus status;
    status.safety = safety;
    status.safety_bits = bits;
    return find_safety_stop(status);
  };
  EXPECT_EQ(stop(1, 1U), "") << "normal";
  EXPECT_EQ(stop(2, 2U), "") << "reduced";
  const std::vector<std::tuple<int, unsigned, std::string>> stops = {{3, 2, "protective stop"},
                                                                     {4, 3, "recovery mode"},
                                                                     {5, 4, "safeguard stop"},
                                                                     {6, 5, "emergency stop of the system"},
                                                                     {7, 6, "emergency stop of the robot"},
                                                                     {8, 8, "safety violation"},
                                                                     {9, 9, "safety fault"},
                                                                     {13, 11, "three-position switch stop"}};
  for (const auto& [safety, bit, name] : stops) {
    EXPECT_THAT(stop(safety, 1U), testing::StartsWith(name + " (safety")) << "by its number alone";
    EXPECT_THAT(stop(1, 1U << bit), testing::StartsWith(name + " (safety")) << "by its bit alone";
  }
  EXPECT_THAT(stop(42, 1U), HasSubstr("not known here"));
}

TEST(UrArm, AnInterruptionInAMotionSendsAStop) {
  ArmBench bench(
      [](State& s, const std::string& script, int run) { obey(s, script, run, ScriptEnd::kDone, 100000); });
  JointTrajectory slow = small_arm_move();
  slow.time = {0.0, 5.0};
  {
    const auto clock = make_steady_clock();
    const TimeLimit over(0.2, *clock);
    EXPECT_THROW(static_cast<void>(bench.arm.follow(slow)), Interrupted);
  }
  EXPECT_TRUE(eventually([&] { return bench.robot.count("def stonestack") == 2; })) << "no stop was sent";
}

TEST(UrArm, NoPowerNoMotion) {
  ArmBench bench([](State& s, const std::string& script, int run) { obey(s, script, run); });
  bench.robot.change([](State& s) { s.set("robot_mode", std::int32_t{3}); });
  ASSERT_TRUE(eventually([&] { return !bench.arm.state().can_move; }));
  EXPECT_THAT(bench.arm.follow(small_arm_move()).reason, HasSubstr("powered off (mode 3)"));
}

}  // namespace
}  // namespace stonestack::hardware
