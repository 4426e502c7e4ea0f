#include "hardware/ur/script_writer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::hardware {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

JointTrajectory small_move() {
  JointTrajectory move;
  move.time = {0.0, 0.5, 1.0};
  move.q = {Joints::Zero(), Joints::Constant(0.1), Joints::Constant(0.2)};
  move.qd = {Joints::Zero(), Joints::Constant(0.3), Joints::Zero()};
  return move;
}

ScriptContext context_of(UrVersion version) {
  ScriptContext context;
  context.version = version;
  context.run = 17;
  context.T_F_T = Pose(Eigen::Translation3d(0, 0, 0.264));
  context.payload = 2.5;
  context.p_F_com = {0, 0, 0.1};
  return context;
}

const UrVersion kCb3{3, 15, 8, 106339}, kOldCb3{3, 8, 0, 0}, kESeries{5, 11, 0, 0};

RobotModel ur10() {
  static const RobotModel robot = read_robot(STONESTACK_SOURCE_DIR "/data/robots/ur10.urdf");
  return robot;
}

TEST(ScriptWriter, Settings) {
  EXPECT_EQ(write_settings(context_of(kCb3)),
            "def stonestack_17():\n"
            "  write_output_integer_register(26, 0)\n"
            "  write_output_integer_register(25, 0)\n"
            "  write_output_float_register(30, 0.0)\n"
            "  write_output_integer_register(24, 17)\n"
            "  set_tcp(p[0.000000000, 0.000000000, 0.264000000, 0.000000000, 0.000000000, 0.000000000])\n"
            "  set_payload(2.500000000, [0.000000000, 0.000000000, 0.100000000])\n"
            "  sync()\n"
            "  global stk_force = 0.0\n"
            "  stk_pose = get_actual_tcp_pose()\n"
            "  write_output_float_register(24, stk_pose[0])\n"
            "  write_output_float_register(25, stk_pose[1])\n"
            "  write_output_float_register(26, stk_pose[2])\n"
            "  write_output_float_register(27, stk_pose[3])\n"
            "  write_output_float_register(28, stk_pose[4])\n"
            "  write_output_float_register(29, stk_pose[5])\n"
            "  write_output_float_register(30, stk_force)\n"
            "  write_output_integer_register(26, 1)\n"
            "end\n");
}

TEST(ScriptWriter, TrajectoryIsWatchedAndTimedOnTheController) {
  const std::string script = write_trajectory(small_move(), context_of(kCb3));
  EXPECT_THAT(script, HasSubstr("  rtde_set_watchdog(\"input_int_register_24\", 10.000000000, \"stop\")\n"));
  EXPECT_THAT(script, HasSubstr("  global stk_dt = 0.008000000\n"));
  EXPECT_THAT(script,
              HasSubstr("  stk_to(1, 0.500000000, [0.100000000, 0.100000000, 0.100000000, 0.100000000, "
                        "0.100000000, 0.100000000], [0.300000000, 0.300000000, 0.300000000, "
                        "0.300000000, 0.300000000, 0.300000000])\n"));
  EXPECT_THAT(script, HasSubstr("stk_to(2, 0.5"));
  EXPECT_THAT(script, HasSubstr("stopj(2.000000000)"));
  EXPECT_THAT(script, Not(HasSubstr("stk_guard")));
  EXPECT_LT(script.find("register(26, 0)"), script.find("register(24, 17)"))
      << "the run id must not appear before the old end state is gone";
  EXPECT_THAT(script, HasSubstr("  if stk_end == 0:\n    stk_end = 1\n  end\n  stk_pose ="));
  EXPECT_THAT(script.substr(script.size() - 50),
              HasSubstr("write_output_integer_register(26, stk_end)\nend\n"));
}

TEST(ScriptWriter, VersionGates) {
  EXPECT_THAT(write_trajectory(small_move(), context_of(kESeries)), HasSubstr("stk_dt = get_steptime()"));
  EXPECT_THAT(write_trajectory(small_move(), context_of({5, 3, 0, 0})), HasSubstr("stk_dt = 0.002000000"));
  const std::string old = write_guarded(small_move(), {}, context_of(kOldCb3));
  EXPECT_THAT(old, HasSubstr("# Before 3.9 (5.3): registers 0..23"));
  EXPECT_THAT(old, HasSubstr("write_output_integer_register(0, 17)"));
  EXPECT_THAT(old, HasSubstr("rtde_set_watchdog(\"input_int_register_0\""));
  EXPECT_THAT(old, HasSubstr("read_input_integer_register(1)"));
  EXPECT_EQ(first_register({3, 9, 0, 0}), 24);
  EXPECT_EQ(first_register({5, 2, 9, 0}), 0);
  ScriptContext comply = context_of({3, 4, 0, 0});
  comply.options.comply_time = 0.3;
  EXPECT_THAT(write_guarded(small_move(), {}, comply), Not(HasSubstr("force_mode_set_damping")));
  comply.version = kCb3;
  const std::string script = write_guarded(small_move(), {}, comply);
  EXPECT_THAT(script, HasSubstr("force_mode_set_damping(0.1"));
  EXPECT_THAT(script, HasSubstr("end_force_mode()"));
}

TEST(ScriptWriter, GuardReadsTheStreamedForce) {
  const std::string script = write_guarded(small_move(), {{0, 0, -1}, 6.0}, context_of(kCb3));
  EXPECT_THAT(script, HasSubstr("read_input_integer_register(25)"));
  EXPECT_THAT(script, HasSubstr("+ -1.000000000 * read_input_float_register(26)) - stk_zero"));
  EXPECT_THAT(script, HasSubstr("if stk_silent > 0.050000000:"));
  EXPECT_THAT(script, HasSubstr("if stk_force <= 6.000000000:"));
  EXPECT_THAT(script, Not(HasSubstr("force_mode"))) << "complying is off by default";
}

TEST(ScriptWriter, BlocksAreClosed) {
  for (const auto& script : {write_trajectory(small_move(), context_of(kCb3)),
                             write_guarded(small_move(), {}, context_of(kESeries)),
                             write_stop(context_of(kCb3)), write_settings(context_of(kCb3))}) {
    int depth = 0, line = 0;
    std::istringstream in(script);
    for (std::string text; std::getline(in, text);) {
      const std::string bare = script_line(script, ++line);
      if (bare == "end" || bare.rfind("elif ", 0) == 0 || bare == "else:") --depth;
      EXPECT_EQ(text.size() - bare.size(), static_cast<std::size_t>(2 * depth)) << text;
      if (bare.back() == ':' && bare.front() != '#') ++depth;
    }
    EXPECT_EQ(depth, 0);
  }
}

TEST(ScriptWriter, NothingThatIsNotANumberPasses) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -inf, 1e12}) {
    JointTrajectory move = small_move();
    move.q[1][3] = bad;
    EXPECT_THROW(static_cast<void>(write_trajectory(move, context_of(kCb3))), InvalidArgument) << bad;
    ScriptContext context = context_of(kCb3);
    context.p_F_com.x() = bad;
    EXPECT_THROW(static_cast<void>(write_settings(context)), InvalidArgument);
    context = context_of(kCb3);
    context.options.stop_acceleration = bad;
    EXPECT_THROW(static_cast<void>(write_stop(context)), InvalidArgument);
    EXPECT_THROW(static_cast<void>(
                     write_guarded(small_move(), {{0, 0, -1}, bad == 1e12 ? nan : bad}, context_of(kCb3))),
                 InvalidArgument);
  }
  EXPECT_THROW(static_cast<void>(write_guarded(small_move(), {{0, 0, -2}, 5}, context_of(kCb3))),
               InvalidArgument);
  EXPECT_THROW(static_cast<void>(write_trajectory({}, context_of(kCb3))), InvalidArgument);
}

TEST(ScriptGate, PassesWhatIsWithinLimits) {
  EXPECT_EQ(find_fault(small_move(), Joints::Constant(0.009), ur10(), context_of(kCb3)), "");
}

TEST(ScriptGate, KeepsTheLimitsOfTheCell) {
  const ScriptContext context = context_of(kCb3);
  const JointTrajectory move = small_move();
  RobotModel robot = ur10();
  const auto tip = [&](const Joints& q) -> Eigen::Vector3d { return forward(robot, q).translation(); };
  const Eigen::Vector3d a = tip(move.q.front()), b = tip(move.q.back()), half(0.01, 0.01, 0.01);
  robot.workspace =
      ToolWorkspace{{a.cwiseMin(b) - half, a.cwiseMax(b) + half}, Pose::Identity(), Pose::Identity()};
  EXPECT_EQ(find_fault(move, Joints::Zero(), robot, context), "");
  robot.workspace->T_F_T.translation().x() = 0.5;
  EXPECT_THAT(find_fault(move, Joints::Zero(), robot, context), HasSubstr("leaves the workspace"));
  robot.workspace->T_F_T.translation().x() = 0.0;
  // Both ends inside, the path between not: what happens between the knots counts.
  JointTrajectory round = move;
  round.q.back() = round.q.front();
  robot.workspace->box = Eigen::AlignedBox3d(a - half * 0.01, a + half * 0.01);
  ASSERT_GT(outside_workspace(robot, round.q[1]), 0.0);
  EXPECT_THAT(find_fault(round, Joints::Zero(), robot, context), HasSubstr("leaves the workspace"));
  robot.workspace.reset();
  robot.velocity *= 0.01;
  EXPECT_THAT(find_fault(move, Joints::Zero(), robot, context), HasSubstr("rad/s, limit"));
  robot.velocity *= 100;
  robot.upper = robot.lower + Joints::Constant(0.1);
  EXPECT_THAT(find_fault(move, Joints::Zero(), robot, context), HasSubstr("limits"));
}

// All joints at up to 0.3 rad/s: the tip is faster the further it is from their axes.
TEST(ScriptGate, KeepsTheSpeedOfTheToolsTip) {
  ScriptContext context = context_of(kCb3);
  const JointTrajectory move = small_move();
  RobotModel robot = ur10();
  const auto fastest = [&] {
    double max = 0.0;
    const auto tip = [&](double t) {
      return (forward(robot, sample(move, t).q) * context.T_F_T).translation().eval();
    };
    for (double t = 0.0; t < move.duration(); t += 1e-4)
      max = std::max(max, (tip(t + 1e-4) - tip(t)).norm() / 1e-4);
    return max;
  };
  robot.tool_speed = fastest();
  EXPECT_EQ(find_fault(move, Joints::Zero(), robot, context), "");
  robot.tool_speed *= 0.97;
  context.T_W_R.translation().z() = 5.0;
  EXPECT_THAT(find_fault(move, Joints::Zero(), robot, context),
              AllOf(testing::ContainsRegex(
                        "the tool at \\(-?[0-9.]+, -?[0-9.]+, [45]\\.[0-9]+\\) m moves at 0\\.[0-9]+ "
                        "m/s, limit 0\\.[0-9]+ m/s, at 0\\.[0-9]+ s"),
                    HasSubstr("limits.tool_speed")));
  const double before = fastest();
  context.T_F_T.translation().x() = -0.5;
  robot.tool_speed = before;
  ASSERT_GT(fastest(), 1.02 * before);
  EXPECT_NE(find_fault(move, Joints::Zero(), robot, context), "") << "it is the tip that counts";
}

TEST(ScriptGate, KeepsTheWholeArmWithinTheFence) {
  const ScriptContext context = context_of(kCb3);
  RobotModel robot = ur10();
  JointTrajectory move = small_move();  // the elbow high, the tool low
  Joints start;
  start << 0.0, -1.8, 1.9, -1.67, -1.57, 0.0;
  for (Joints& q : move.q) q += start;
  const Eigen::Vector3d far = Eigen::Vector3d::Constant(5.0);
  robot.fence = ArmFence{{-far, far}, Pose::Identity(), {}};
  EXPECT_EQ(find_fault(move, start, robot, context), "");
  const Eigen::Vector3d elbow = link_poses(robot, start)[3].translation();
  ASSERT_GT(elbow.z(), forward(robot, start).translation().z() + 0.1);
  robot.fence->box.max().z() = elbow.z() - 0.02;
  EXPECT_THAT(find_fault(move, start, robot, context),
              testing::ContainsRegex("the (forearm|upper arm) at .* leaves the fence"));
  robot.fence->box.max().z() = 5.0;
  robot.fence->p_F_mounted = {{0.0, 0.0, 1.0}};  // a long tool
  const double low = (forward(robot, start) * Eigen::Vector3d(0.0, 0.0, 1.0)).z();
  robot.fence->box.min().z() = low - 0.5;
  EXPECT_EQ(find_fault(move, start, robot, context), "");
  robot.fence->box.min().z() = low + 0.02;
  EXPECT_THAT(find_fault(move, start, robot, context), HasSubstr("the gripper at"));
}

// small_move begins with 1.2 rad/s^2; a cell may allow less. Nor may it begin or end in between.
TEST(ScriptGate, KeepsTheAccelerations) {
  const ScriptContext context = context_of(kCb3);
  RobotModel robot = ur10();
  robot.acceleration.setConstant(1.25);
  EXPECT_EQ(find_fault(small_move(), Joints::Zero(), robot, context), "");
  robot.acceleration[3] = 1.15;
  EXPECT_THAT(find_fault(small_move(), Joints::Zero(), robot, context),
              AllOf(HasSubstr("joint 4 changes its speed by 1."), HasSubstr("limit 1.15 rad/s^2")));
  robot.acceleration.setConstant(1.25);
  for (const std::size_t end : {0U, 2U}) {
    JointTrajectory jump = small_move();
    jump.qd[end][2] = 0.05;
    EXPECT_THAT(find_fault(jump, Joints::Zero(), robot, context), HasSubstr("joint 3 changes its speed"));
  }
}

TEST(ScriptGate, RefusesWithTheJointAndTheValue) {
  const ScriptContext context = context_of(kCb3);
  RobotModel robot = ur10();
  robot.acceleration.setConstant(1e6);  // not what this is about
  const auto fault = [&](auto change) {
    JointTrajectory move = small_move();
    change(move);
    return find_fault(move, Joints::Zero(), robot, context);
  };
  EXPECT_THAT(fault([](auto& m) { m.q[1][2] = NAN; }), HasSubstr("knot 1"));
  EXPECT_THAT(fault([](auto& m) { m.time[2] = 0.5; }), HasSubstr("times must"));
  EXPECT_THAT(fault([](auto& m) { m.time[0] = 0.1; }), HasSubstr("times must"));
  EXPECT_THAT(fault([](auto& m) { m.qd.pop_back(); }), HasSubstr("as many times"));
  EXPECT_THAT(fault([](auto& m) { m.q[0][0] = 0.011; }), HasSubstr("from where the arm is"));
  EXPECT_THAT(fault([](auto& m) { m.q[1][4] = 3.0; }), HasSubstr("joint 5 at"));
  EXPECT_THAT(fault([](auto& m) { m.qd[1][5] = 20.0; }), HasSubstr("joint 6 at"));
  JointTrajectory far = small_move();
  for (double& t : far.time) t *= 100;
  far.q[2][1] = 7.0;
  EXPECT_THAT(find_fault(far, Joints::Zero(), robot, context), HasSubstr("limits"));
  EXPECT_THAT(find_fault(small_move(), Joints::Constant(NAN), ur10(), context), HasSubstr("from where"));
}

TEST(ScriptWriter, LineForAPerson) {
  EXPECT_EQ(script_line("a\n  b\n", 2), "b");
  EXPECT_EQ(script_line("a\n", 5), "");
  EXPECT_EQ(script_line("a\n", 0), "");
  EXPECT_LE(script_name(2147483647).size(), 31u);
}

}  // namespace
}  // namespace stonestack::hardware
