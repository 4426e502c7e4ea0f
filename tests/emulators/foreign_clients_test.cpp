// What came to light when the vendors' own clients were run against the simulated controller. The scripts are
// design choice; they do what made those clients' scripts fail.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "emulators/ur/dashboard_session.hpp"
#include "emulators/ur/rtde_session.hpp"
#include "script_bench.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

using testing::HasSubstr;
using testing::MatchesRegex;

TEST(UrForeignClients, AnotherToolCentrePointMovesNothing) {
  // ur_rtde ends force mode and jogging with stopl; a set_tcp after that made the flange jump by the
  // difference.
  ScriptBench bench;
  bench.output("def tool():\n  speedl([0, 0, 0.05, 0, 0, 0], a=0.5, t=0.3)\n  stopl(10)\nend\n");
  EXPECT_EQ(bench.exceptions, "");
  const Joints before = bench.controller.motion.q();
  bench.output("def tool():\n  stopl(10)\n  set_tcp(p[0, 0.02, 0.3, 0.4, 0, 0])\n  sleep(0.2)\nend\n");
  EXPECT_EQ(bench.errors, "");
  EXPECT_LT((bench.controller.motion.q() - before).norm(), 1e-9);
  EXPECT_NEAR(bench.controller.motion.geometry().T_F_P.translation().z(), 0.3, 1e-12);
}

TEST(UrForeignClients, ASpeedGoesOnFromWhereTheNewToolIs) {
  ScriptBench bench;
  bench.controller.run_script(
      "def tool():\n  thread go():\n    while True:\n      speedl([0, 0, 0.05, 0, 0, 0], a=0.5, t=0.1)\n    "
      "end\n"
      "  end\n  run go()\n  sleep(0.5)\n  set_tcp(p[0, 0, 0.2, 0, 0, 0])\n  sleep(0.5)\nend\n");
  bench.run(0.45);
  for (int k = 0; k < 50; ++k) {
    const Joints before = bench.controller.motion.q();
    bench.run(bench.controller.period());
    ASSERT_LT((bench.controller.motion.q() - before).cwiseAbs().maxCoeff(), 0.2 * bench.controller.period());
  }
  EXPECT_EQ(bench.errors + bench.exceptions, "");
}

TEST(UrForeignClients, TimeIsTheControllersEvenBesideAVariableOfThatName) {
  ScriptBench bench;
  EXPECT_EQ(bench.output("def clock():\n"
                         "  global last = 0.0\n"
                         "  def within(distance, time):\n"
                         "    return distance / time < 2\n"
                         "  end\n"
                         "  last = time()\n"
                         "  sleep(0.4)\n"
                         "  passed = time() - last\n"
                         "  textmsg(passed > 0.39 and passed < 0.41 and last > 40)\n"
                         "  textmsg(within(1, passed))\n"
                         "end\n"),
            "True|False");
  EXPECT_EQ(bench.exceptions, "");
}

TEST(UrForeignClients, AToolContactReportsHowLongAgoItBegan) {
  ScriptBench bench("5.12.2.1101534");
  const auto touch = [&](const char* direction) {
    return bench.value(concat("tool_contact(direction=", direction, ")"));
  };
  bench.run(0.1);
  EXPECT_EQ(touch("[0,0,0,0,0,0]"), "0");
  bench.plant.set_wrench({0, 0, 12}, Eigen::Vector3d::Zero());
  bench.run(20 * bench.controller.period());
  EXPECT_EQ(touch("[0,0,-1,0,0,0]"), "20");
  EXPECT_NE(touch("[0,0,0,0,0,0]"), "0") << "any direction";
  EXPECT_NE(touch("p[0,0,-0.05,0,0,0]"), "0");
  EXPECT_EQ(touch("[0,0,1,0,0,0]"), "0") << "it is left that way";
  bench.plant.set_wrench(Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  bench.run(bench.controller.period());
  EXPECT_EQ(touch("[0,0,-1,0,0,0]"), "0");
}

TEST(UrForeignClients, StructuresHaveNamedMembers) {
  // UR's client library keeps the gains of a joint controller in one.
  ScriptBench bench("5.23.0.1234");
  EXPECT_EQ(bench.output("def gains():\n"
                         "  global gains = struct(kp=[900, 900.5], kd=3)\n"
                         "  def set(value):\n"
                         "    gains.kp[1] = value\n"
                         "    gains.kd = [1, 2]\n"
                         "  end\n"
                         "  before = gains\n"
                         "  set(5)\n"
                         "  textmsg(gains.kp * [2, 3] - gains.kd * [1, 1])\n"
                         "  textmsg(before.kd + before.kp[0] * 2)\n"
                         "  textmsg(struct(a=1, b=struct(c=\"x\")).b.c)\n"
                         "  textmsg(gains == before)\n"
                         "  textmsg(before)\n"
                         "end\n"),
            "[1799,13]|1803|x|False|struct(kp=[900,900.5],kd=3)");
  EXPECT_EQ(bench.exceptions, "");
  bench.output("def lacking():\n  s = struct(a=1)\n  textmsg(s.b)\nend\n");
  EXPECT_THAT(bench.exceptions, HasSubstr("The struct has no member 'b'"));
  bench.output("def unnamed():\n  s = struct(1)\nend\n");
  EXPECT_THAT(bench.exceptions, HasSubstr("wrong arguments for struct"));
  bench.output("def none():\n  s = [1]\n  s.a = 1\nend\n");
  EXPECT_THAT(bench.exceptions, HasSubstr("expected Struct, got List"));
}

TEST(UrForeignClients, EmptyListsAndMembersCountTowardsAListsLength) {
  using urscript::Fields;
  using urscript::List;
  EXPECT_NO_THROW(urscript::check_size(List(1000, List{})));
  EXPECT_THROW(urscript::check_size(List(20000, List{})), urscript::ScriptError);
  EXPECT_THROW(urscript::check_size(List(200, Fields(100, {"a", 1}))), urscript::ScriptError);
}

TEST(UrForeignClients, ControllersBeforeStructuresReadScriptsThatNameMembers) {
  // What the library puts in place of the structure there is a number; the members are never asked for.
  ScriptBench bench;
  const std::string members =
      "  def gain():\n    gains.kp = [1]\n    return gains.kp\n  end\n  textmsg(gains)\nend\n";
  EXPECT_EQ(bench.output("def old():\n  global gains = 0\n" + members), "0");
  EXPECT_EQ(bench.exceptions, "");
  bench.output("def old():\n  global gains = struct(kp=[0])\n" + members);
  EXPECT_THAT(bench.exceptions, HasSubstr("compile_error_name_not_found:struct"));
}

/// Joint 2 meets something elastic at kAt.
class Obstructed final : public Plant {
 public:
  static constexpr double kAt = -1.2;  // rad
  Obstructed() { state_.q = ScriptBench::start(); }
  [[nodiscard]] PlantState state() override { return state_; }
  PlantState step(const Joints& q_target, double seconds) override {
    state_.qd = (q_target - state_.q) / seconds;
    state_.q = q_target;
    const double depth = state_.q[1] - kAt;
    state_.hit = depth > 0 ? "a box" : "";
    state_.force_R.z() = std::max(0.0, 5000 * depth);
    return state_;
  }

 private:
  PlantState state_;
};

TEST(UrForeignClients, AnArmThatHitSomethingCanBeMovedAwayOnceItsStopIsAcknowledged) {
  // UR's control loop example moves to fixed poses; in the simulated cell a table may obstruct them.
  const RobotModel robot = read_robot("ur10");
  Obstructed plant;
  UrController controller(ScriptBench::options("3.15.8.106339", {}), robot, plant);
  const auto run = [&](double seconds) {
    for (double t = 0; t < seconds; t += controller.period()) controller.step();
  };
  const auto turn = [&](double by, double seconds) {
    controller.run_script(concat("def turn():\n  q = get_actual_joint_positions()\n  q[1] = q[1] + ", by,
                                 "\n  movej(q, a=1, v=0.2)\nend\n"));
    run(seconds);
  };
  turn(0.3, 2.0);
  ASSERT_EQ(controller.safety_mode, SafetyMode::kProtectiveStop);
  controller.stop_program();
  run(5.0);
  ASSERT_TRUE(controller.unlock_protective_stop());
  run(1.0);
  EXPECT_EQ(controller.safety_mode, SafetyMode::kNormal) << "touching is not colliding";
  turn(0.3, 2.0);
  EXPECT_EQ(controller.safety_mode, SafetyMode::kProtectiveStop) << "pressing on is";
  controller.stop_program();
  run(6.0);
  ASSERT_TRUE(controller.unlock_protective_stop());
  turn(-0.15, 3.0);
  EXPECT_EQ(controller.safety_mode, SafetyMode::kNormal);
  EXPECT_LT(controller.plant().q[1], -1.25);
  turn(0.3, 2.0);
  EXPECT_EQ(controller.safety_mode, SafetyMode::kProtectiveStop) << "a new touch is a new collision";
}

TEST(UrForeignClients, AnArmThatHitsSomethingIsNotDrivenIntoItWhileItBrakes) {
  const RobotModel robot = read_robot("ur10");
  for (const bool brakes_already : {false, true}) {
    Obstructed plant;
    UrController controller(ScriptBench::options("5.12.2.1101534", {}), robot, plant);
    controller.run_script("def turn():\n  speedj([0,0.5,0,0,0,0], 5, 60)\nend\n");
    const auto hits = [&] { return !controller.plant().hit.empty(); };
    for (int k = 0; k < 2000 && !hits(); ++k) {
      if (brakes_already && controller.plant().q[1] > Obstructed::kAt - 0.005)
        controller.protective_stop(153, "test");
      controller.step();
    }
    ASSERT_TRUE(hits());
    EXPECT_EQ(controller.safety_mode, SafetyMode::kProtectiveStop);
    const double q = controller.plant().q[1];
    EXPECT_LT(q, Obstructed::kAt + 0.5 * controller.period());
    for (int k = 0; k < 100; ++k) controller.step();
    EXPECT_EQ(controller.plant().q[1], q);
  }
}

TEST(UrForeignClients, WaypointIsTheEndOfTheMoveThroughout) {
  // ur_rtde's getTargetWaypoint asks for it while another thread moves.
  for (const char* move : {"movej(q, a=1, v=0.5)", "movel(goal, a=1, v=0.1)", "movep(goal, a=1, v=0.1)",
                           "movec(pose_trans(start, p[0.05,0.03,0,0,0,0]), goal, a=1, v=0.1)"}) {
    ScriptBench bench;
    EXPECT_EQ(bench.output(concat("def w():\n"
                                  "  start = get_actual_tcp_pose()\n"
                                  "  goal = pose_trans(start, p[0.1,0,0,0,0,0])\n"
                                  "  q = get_inverse_kin(goal)\n"
                                  "  thread mover():\n    ",
                                  move,
                                  "\n  end\n"
                                  "  textmsg(point_dist(get_target_waypoint(), start) < 1e-6)\n"
                                  "  moving = run mover()\n"
                                  "  i = 0\n  worst = 0\n"
                                  "  while i < 10:\n"
                                  "    sleep(0.02)\n"
                                  "    worst = worst + point_dist(get_target_waypoint(), goal)\n"
                                  "    i = i + 1\n  end\n"
                                  "  textmsg(worst < 1e-6)\n"
                                  "  kill moving\n"
                                  "  stopl(1)\n"
                                  "  textmsg(point_dist(get_target_waypoint(), get_target_tcp_pose()))\n"
                                  "end\n"),
                           10.0),
              "True|True|0")
        << move;
    EXPECT_EQ(bench.exceptions, "") << move;
  }
}

TEST(UrForeignClients, NothingIsSteadyInForceModeOrWhileTheArmIsGuidedByHand) {
  // Script manual, is_steady: "always return false in modes other than the standard position mode".
  ScriptBench bench("5.12.2.1101534");
  EXPECT_EQ(bench.output("def s():\n"
                         "  textmsg(is_steady())\n"
                         "  freedrive_mode()\n  textmsg(is_steady())\n"
                         "  end_freedrive_mode()\n  textmsg(is_steady())\n"
                         "  teach_mode()\n  textmsg(is_steady())\n"
                         "  end_teach_mode()\n  textmsg(is_steady())\n"
                         "  force_mode(p[0,0,0,0,0,0], [0,0,1,0,0,0], [0,0,0,0,0,0], 2, [1,1,1,1,1,1])\n"
                         "  sync()\n  textmsg(is_steady())\n"
                         "  end_force_mode()\n  textmsg(is_steady())\n"
                         "  teach_mode()\n"
                         "end\n"),
            "True|False|True|False|True|False|True");
  EXPECT_EQ(bench.exceptions, "");
  EXPECT_EQ(bench.value("is_steady()"), "True") << "the mode ends with its program";
}

TEST(UrForeignClients, ThePayloadsInertiaIsKeptAndReported) {
  // ur_rtde's script of 2025 prints it back: without the function nothing of the script ran on 5.10 and
  // later.
  ScriptBench bench("5.12.2.1101534");
  EXPECT_EQ(
      bench.output("def load():\n"
                   "  textmsg(get_target_payload_inertia())\n"
                   "  set_target_payload(2, get_target_payload_cog(), [0.1, 0.2, 0.3, 0, 0, 0.01])\n"
                   "  textmsg(get_target_payload_inertia())\n"
                   "  set_target_payload(2, [0, 0, 0.1], inertia=[0.1, 0, 0, 0, 0, 0], transition_time=0.1)\n"
                   "  set_payload(1)\n"
                   "  textmsg(get_target_payload_inertia())\n"
                   "end\n"),
      "[0,0,0,0,0,0]|[0.1,0.2,0.3,0,0,0.01]|[0,0,0,0,0,0]");
  EXPECT_EQ(bench.exceptions, "");
  ScriptBench older("5.9.0.1031618");
  older.value("get_target_payload_inertia()");
  EXPECT_THAT(older.exceptions, HasSubstr("compile_error_name_not_found:get_target_payload_inertia"));
}

TEST(UrForeignClients, RtdeSeesNowAndThenWhatAScriptWritesOverAtOnce) {
  // ur_rtde waits for a 2 (done) that its script, for what it takes for a command of every step (the flange's
  // pose), turns into a 1 (ready) at once. On robots it comes to see it.
  ScriptBench bench;
  UrController& c = bench.controller;
  c.run_script(
      "def resident():\n"
      "  write_output_integer_register(1, 7)\n"
      "  while True:\n"
      "    if read_input_integer_register(0) == 58:\n"
      "      write_output_integer_register(0, 2)\n"
      "    end\n"
      "    write_output_integer_register(0, 1)\n"
      "    sync()\n"
      "  end\n"
      "end\n");
  const auto read = rtde_reader(*find_rtde_output("output_int_register_0"));
  const auto once = rtde_reader(*find_rtde_output("output_int_register_1"));
  const auto seen = [&](int steps) {
    int done = 0;
    for (int k = 0; k < steps; ++k) {
      bench.run(c.period());
      const auto value = std::get<std::int32_t>(read(c));
      EXPECT_TRUE(value == 1 || value == 2) << value;
      EXPECT_EQ(std::get<std::int32_t>(once(c)), 7);
      if (value == 2) ++done;
    }
    return done;
  };
  EXPECT_EQ(seen(100), 0);
  c.registers.in_int[0] = 58;
  const int done = seen(100);
  EXPECT_GT(done, 0);
  EXPECT_LT(done, 20) << "it is the exception";
  c.registers.in_int[0] = 0;
  EXPECT_EQ(seen(100), 0);
}

TEST(UrForeignClients, DashboardRolesAndModesAreAnsweredAsUrsLibraryWantsThem) {
  ScriptBench old, recent("5.12.2.1101534");
  const auto ask = [](ScriptBench& bench, const char* command) {
    return answer_dashboard(bench.controller, command).line;
  };
  EXPECT_EQ(ask(old, "getUserRole"), "NONE");
  EXPECT_EQ(ask(old, "setUserRole operator"), "Setting user role: operator");
  EXPECT_EQ(ask(old, "getUserRole"), "OPERATOR");
  EXPECT_EQ(ask(old, "setUserRole king"), "Failed setting user role: king");
  EXPECT_EQ(ask(old, "setUserRole"), "Setting user role: none");
  EXPECT_EQ(ask(old, "saveLog"), "Log saved to disk");
  EXPECT_THAT(ask(old, "set operational mode manual"), MatchesRegex("could not understand: .*"));
  EXPECT_THAT(ask(recent, "getUserRole"), MatchesRegex("could not understand: .*"));
  EXPECT_EQ(ask(recent, "set operational mode manual"), "Operational mode manual is set");
  EXPECT_EQ(ask(recent, "get operational mode"), "MANUAL");
  EXPECT_THAT(ask(recent, "clear operational mode"),
              MatchesRegex("No longer controlling the operational mode.*"));
  EXPECT_EQ(ask(recent, "get operational mode"), "NONE");
}

std::string packet(char type, const std::string& payload) {
  const auto size = payload.size() + 3;
  return {std::string{static_cast<char>(size >> 8), static_cast<char>(size & 0xFF), type} + payload};
}

// A mask selects what this package sets. It does not set it again with every later package of anybody.
TEST(UrForeignClients, AMaskHoldsForItsOwnPackage) {
  ScriptBench bench;
  InputOwners owners;
  RtdeSession session(1, bench.controller, owners);
  const auto send = [&](const std::string& bytes) { return session.feed(bytes); };
  (void)send(packet('V', std::string("\0\2", 2)));
  (void)send(packet('I', "standard_digital_output_mask,standard_digital_output"));
  (void)send(packet('I', "speed_slider_mask,speed_slider_fraction"));
  (void)send(packet('I', "standard_analog_output_mask,standard_analog_output_0"));
  (void)send(packet('U', std::string("\1\1\1", 3)));
  EXPECT_EQ(bench.controller.io.digital_out, 1U);
  bench.output("def a():\n  set_standard_digital_out(0, False)\nend\n");
  (void)send(packet('U', std::string("\2\0\0\0\1\x3F\xE0\0\0\0\0\0\0", 13)));  // slider at 0.5
  EXPECT_EQ(bench.controller.speed_slider, 0.5);
  EXPECT_EQ(bench.controller.io.digital_out, 0U) << "the program's word is the last";
  (void)send(packet('U', std::string("\3\1\x3F\xE0\0\0\0\0\0\0", 10)));
  (void)send(packet('U', std::string("\3\1\x7F\xF8\0\0\0\0\0\0", 10)));  // not a number
  EXPECT_EQ(bench.controller.io.analog_out[0], 0.5);
}

}  // namespace
}  // namespace stonestack::emulators
