// What the controller's motion functions do to the arm, and what stops it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "motion/timing.hpp"
#include "script_bench.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::emulators {
namespace {

using ::testing::HasSubstr;

std::string list(const Joints& q) {
  std::string text = "[";
  for (int j = 0; j < 6; ++j) {
    char number[32];
    std::snprintf(number, sizeof(number), "%.12g", q[j]);
    text += (j ? "," : "") + std::string(number);
  }
  return text + "]";
}

TEST(UrMotion, MovejIsTheTrapezoidOfItsLeadingJoint) {
  ScriptBench bench;
  Joints goal = ScriptBench::start();
  goal[0] += 1.0;
  goal[1] -= 0.5;
  bench.controller.run_script("def m():\n  movej(" + list(goal) + ", a=2.0, v=0.8)\nend\n");
  // By hand: 0.4 s up to speed over 0.16 rad, 0.68 rad at 0.8 rad/s, 0.4 s down.
  const double up = 0.4, steady = 0.68 / 0.8, whole = 2 * up + steady;
  double t = 0;
  while (bench.controller.runtime() == RuntimeState::kPlaying || t == 0) {
    bench.run(bench.controller.period());
    t += bench.controller.period();
    double displacement = 1.0;
    if (t < up)
      displacement = 0.5 * 2.0 * t * t;
    else if (t < up + steady)
      displacement = 0.16 + 0.8 * (t - up);
    else if (t < whole)
      displacement = 1.0 - 0.5 * 2.0 * (whole - t) * (whole - t);
    const Joints expected = ScriptBench::start() + displacement * (goal - ScriptBench::start());
    ASSERT_LT((bench.controller.plant().q - expected).cwiseAbs().maxCoeff(), 1e-9) << "at " << t;
    ASSERT_LT(t, 5.0);
  }
  EXPECT_NEAR(t, whole, 3 * bench.controller.period());
  EXPECT_LT((bench.controller.plant().q - goal).norm(), 1e-12);
}

// The planner's own timing of the same straight joint motion, through the kinematics' trajectory type.
TEST(UrMotion, MovejAgreesWithThePlannersTiming) {
  ScriptBench bench("5.12.2.1101534");
  Joints goal = ScriptBench::start();
  goal << 0.7, -1.0, 1.2, -1.4, -1.9, 0.9;
  TimingLimits limits;
  const double v = 0.6, a = 1.1;
  limits.velocity = Joints::Constant(v);
  limits.acceleration = Joints::Constant(a);
  const JointTrajectory plan = time_path({ScriptBench::start(), goal}, limits);
  bench.controller.run_script("def m():\n  movej(" + list(goal) + ", a=1.1, v=0.6)\nend\n");
  double worst = 0;
  for (int k = 1; k * bench.controller.period() < plan.duration(); ++k) {
    bench.run(bench.controller.period());
    worst = std::max(
        worst,
        (bench.controller.plant().q - sample(plan, k * bench.controller.period()).q).cwiseAbs().maxCoeff());
  }
  EXPECT_LT(worst, 1e-3);
}

TEST(UrMotion, MovejInAGivenTime) {
  ScriptBench bench;
  Joints goal = ScriptBench::start();
  goal[5] += 0.3;
  bench.controller.run_script("def m():\n  movej(" + list(goal) + ", t=2.0)\nend\n");
  bench.run(bench.controller.period());
  EXPECT_NEAR(bench.run_to_end(), 2.0, 0.03);
  EXPECT_LT((bench.controller.plant().q - goal).norm(), 1e-9);
}

TEST(UrMotion, MovelKeepsToTheLineAtItsSpeed) {
  ScriptBench bench;
  const auto& geometry = bench.controller.motion.geometry();
  const Pose begin = geometry.T_B_P(ScriptBench::start());
  bench.controller.run_script(
      "def m():\n  movel(pose_trans(get_actual_tcp_pose(), p[0,0,0.2,0,0,0]), a=0.5, v=0.1)\nend\n");
  double top = 0;
  for (int k = 0; k < 500 && (k == 0 || bench.controller.program_running()); ++k) {
    const Eigen::Vector3d before = geometry.T_B_P(bench.controller.plant().q).translation();
    bench.run(bench.controller.period());
    const Pose now = geometry.T_B_P(bench.controller.plant().q);
    top = std::max(top, (now.translation() - before).norm() / bench.controller.period());
    const Eigen::Vector3d displacement =
        begin.rotation().transpose() * (now.translation() - begin.translation());
    ASSERT_LT(displacement.head<2>().norm(), 1e-7);
    ASSERT_LT(difference(begin, now).angle, 1e-7);
  }
  EXPECT_NEAR(top, 0.1, 1e-4);
  const Pose end = geometry.T_B_P(bench.controller.plant().q);
  EXPECT_NEAR((end.translation() - begin.translation()).norm(), 0.2, 1e-7);
}

TEST(UrMotion, TheControllersBaseIsTurnedAgainstTheUrdfs) {
  ScriptBench bench;
  const Eigen::Vector3d p_R = forward(bench.robot, ScriptBench::start()).translation();
  const Eigen::Vector3d p_B = bench.controller.motion.geometry().T_B_F(ScriptBench::start()).translation();
  EXPECT_NEAR(p_B.x(), -p_R.x(), 1e-9);
  EXPECT_NEAR(p_B.y(), -p_R.y(), 1e-9);
  EXPECT_NEAR(p_B.z(), p_R.z(), 1e-9);
  EXPECT_EQ(ScriptBench().value("get_forward_kin([0,0,0,0,0,0], p[0,0,0,0,0,0])").substr(0, 10),
            "p[-1.1843,");
}

TEST(UrMotion, BlendsDoNotStopAtTheCorner) {
  const auto run = [](const char* radius) {
    ScriptBench bench;
    bench.controller.run_script(std::string("def m():\n"
                                            "  a = get_actual_tcp_pose()\n"
                                            "  b = pose_trans(a, p[0,0,0.1,0,0,0])\n"
                                            "  movel(b, a=0.5, v=0.1, r=") +
                                radius + ")\n  movel(pose_trans(b, p[0.1,0,0,0,0,0]), a=0.5, v=0.1)\nend\n");
    bench.run(0.3);
    double slowest = 1.0;
    const auto& geometry = bench.controller.motion.geometry();
    while (bench.controller.program_running()) {
      bench.run(bench.controller.period());
      const auto& now = bench.controller.plant();
      const double displacement =
          (geometry.T_B_P(now.q).translation() - geometry.T_B_P(ScriptBench::start()).translation()).norm();
      if (displacement < 0.13) slowest = std::min(slowest, geometry.twist(now.q, now.qd).head<3>().norm());
    }
    return slowest;
  };
  EXPECT_LT(run("0"), 0.01);
  EXPECT_GT(run("0.02"), 0.03);
}

TEST(UrMotion, ServojFollowsWithItsDelay) {
  ScriptBench bench;
  bench.controller.run_script(
      "def s():\n  q = get_actual_joint_positions()\n  i = 0\n"
      "  while i < 250:\n    q[0] = q[0] + 0.0008\n"  // 0.1 rad/s
      "    servoj(q, t=0.008, lookahead_time=0.1, gain=300)\n    i = i + 1\n  end\n"
      "  textmsg(q[0] - get_actual_joint_positions()[0])\n  stopj(5)\nend\n");
  bench.run_to_end();
  const double lag = std::stod(bench.texts) / 0.1;
  EXPECT_NEAR(lag, 0.1 + 4.0 / 300.0, 0.01) << "seconds behind a target at steady speed";
  EXPECT_FALSE(bench.controller.motion.moving());
}

TEST(UrMotion, SpeedsRampAndStop) {
  ScriptBench bench;
  bench.controller.run_script("def s():\n  speedj([0.5,0,0,0,0,0.25], 1.0, 2.0)\n  stopj(2.0)\nend\n");
  bench.run(0.248);
  EXPECT_NEAR(bench.controller.motion.qd()[0], 0.248, 0.009) << "1 rad/s^2";
  EXPECT_NEAR(bench.controller.motion.qd()[5], 0.124, 0.005);
  bench.run(1.0);
  EXPECT_NEAR(bench.controller.motion.qd()[0], 0.5, 1e-12);
  bench.run(0.752 + 0.136);
  EXPECT_NEAR(bench.controller.motion.qd()[0], 0.5 - 2.0 * 0.136, 0.03) << "braking";
  bench.run_to_end();
  EXPECT_FALSE(bench.controller.motion.moving());
  // Way: 0.125 up, 0.5 * 1.5 steady, 0.0625 down.
  EXPECT_NEAR(bench.controller.plant().q[0] - ScriptBench::start()[0], 0.125 + 0.75 + 0.0625, 0.01);

  ScriptBench line;
  const Pose begin = line.controller.motion.geometry().T_B_P(ScriptBench::start());
  line.controller.run_script("def s():\n  speedl([0,0,-0.05,0,0,0], 0.5, 1.0)\n  stopl(1.0)\nend\n");
  line.run(line.controller.period());
  line.run_to_end();
  const Eigen::Vector3d displacement =
      line.controller.motion.geometry().T_B_P(line.controller.plant().q).translation() - begin.translation();
  EXPECT_NEAR(displacement.z(), -(0.05 * 0.95 + 0.00125), 1e-3);
  EXPECT_LT(displacement.head<2>().norm(), 1e-7);
}

TEST(UrMotion, AProgramThatEndsInMotionIsBraked) {
  ScriptBench bench;
  bench.output("def s():\n  speedj([0.5,0,0,0,0,0], 2.0, 0.5)\nend\n");
  bench.run(0.5);
  EXPECT_FALSE(bench.controller.motion.moving());
}

TEST(UrMotion, JointLimitsAndSpeedsStopTheArm) {
  ScriptBench bench;
  bench.controller.run_script("def s():\n  speedj([0,0,0,0,0,1.0], 5.0, 20)\n  textmsg(\"no\")\nend\n");
  bench.run(10.0);
  EXPECT_EQ(bench.controller.safety_mode, SafetyMode::kProtectiveStop);
  EXPECT_THAT(bench.errors, HasSubstr("position limit"));
  EXPECT_LE(bench.controller.plant().q[5], bench.robot.upper[5] + 1e-9);
  EXPECT_EQ(bench.controller.runtime(), RuntimeState::kPaused);
  EXPECT_EQ(bench.texts, "");

  ScriptBench jump;
  Joints far = ScriptBench::start();
  far[0] += 1.5;
  jump.controller.run_script("def s():\n  servoj(" + list(far) + ", lookahead_time=0.03, gain=2000)\nend\n");
  jump.run(0.1);
  EXPECT_EQ(jump.controller.safety_mode, SafetyMode::kProtectiveStop);
  EXPECT_THAT(jump.errors, HasSubstr("faster than its limit"));
}

TEST(UrMotion, ProtectiveStopsCanBeAcknowledgedAfterFiveSeconds) {
  ScriptBench bench;
  bench.controller.run_script("def s():\n  protective_stop()\n  textmsg(\"on\")\nend\n");
  bench.run(1.0);
  EXPECT_EQ(bench.controller.safety_mode, SafetyMode::kProtectiveStop);
  EXPECT_FALSE(bench.controller.program_running());
  EXPECT_FALSE(bench.controller.unlock_protective_stop());
  bench.run(4.1);
  EXPECT_TRUE(bench.controller.unlock_protective_stop());
  bench.run(0.1);
  EXPECT_EQ(bench.texts, "") << "it stays paused until it is resumed";
  EXPECT_TRUE(bench.controller.resume_program());
  bench.run(0.1);
  EXPECT_EQ(bench.texts, "on");
}

TEST(UrMotion, AProtectiveStopBrakesAlongThePathAndPlayCompletesTheMove) {
  ScriptBench bench("5.12.2.1101534");
  UrController& c = bench.controller;
  Joints goal = ScriptBench::start();
  goal[0] += 0.8;
  goal[1] -= 0.4;
  c.run_script("def m():\n  movej(" + list(goal) + ", a=2.0, v=1.0)\n  textmsg(\"there\")\nend\n");
  bench.run(0.7);
  ASSERT_NEAR(c.plant().qd[0], 1.0, 1e-6);
  c.protective_stop(157, "test");
  const double q_stop = c.plant().q[0];
  double hardest = 0.0;
  for (int k = 0; k < 100; ++k) {
    const Joints qd = c.plant().qd;
    bench.run(c.period());
    hardest = std::max(hardest, (c.plant().qd - qd).cwiseAbs().maxCoeff() / c.period());
    const Joints moved = c.plant().q - ScriptBench::start();
    ASSERT_NEAR(moved[1], -0.5 * moved[0], 1e-9) << "off its path";
  }
  EXPECT_NEAR(hardest, 13.0, 1.0) << "rad/s^2";
  EXPECT_NEAR(c.plant().q[0] - q_stop, 0.5 / 13.0, 0.003);
  EXPECT_EQ(c.runtime(), RuntimeState::kPaused);
  const Joints held = c.plant().q;
  bench.run(5.0);
  EXPECT_TRUE(c.unlock_protective_stop());
  bench.run(1.0);
  EXPECT_EQ(c.plant().q, held) << "unlocking alone moves nothing";
  EXPECT_EQ(bench.texts, "");
  EXPECT_TRUE(c.resume_program());
  bench.run_to_end();
  EXPECT_LT((c.plant().q - goal).norm(), 1e-9);
  EXPECT_EQ(bench.texts, "there");
}

TEST(UrMotion, AMoveThatCannotBeMadeStopsTheArmAgainAfterPlay) {
  Joints beyond = ScriptBench::start();
  beyond[5] = 7.0;
  for (const std::string& motion :
       {"movej(" + list(beyond) + ", v=1.5)", std::string("speedj([0,0,0,0,0,1.5], 5.0, 60)"),
        std::string("movel(p[0,0,0.1,0,0,0], v=0.5)")}) {
    ScriptBench bench;
    UrController& c = bench.controller;
    c.run_script("def m():\n  " + motion + "\n  textmsg(\"there\")\nend\n");
    bench.run(10.0);
    ASSERT_EQ(c.safety_mode, SafetyMode::kProtectiveStop) << motion;
    const Joints held = c.plant().q;
    for (int k = 0; k < 3; ++k) {
      bench.run(5.1);
      ASSERT_TRUE(c.unlock_protective_stop()) << motion;
      EXPECT_TRUE(c.resume_program()) << motion;
      bench.run(0.5);
      EXPECT_EQ(c.safety_mode, SafetyMode::kProtectiveStop) << motion;
      EXPECT_LT((c.plant().q - held).cwiseAbs().maxCoeff(), 0.03) << motion << ": less than one step on";
    }
    EXPECT_EQ(bench.texts, "") << motion;
  }
}

TEST(UrMotion, AStoppedProgramLeavesNoMotionToAPauseOrProtectiveStop) {
  Joints goal = ScriptBench::start();
  goal[0] += 1.0;
  for (const bool protective : {false, true})
    for (const double until_stopped : {0.0, 0.016, 0.5})
      for (const std::string& motion :
           {"movej(" + list(goal) + ")", std::string("speedj([0.5,0,0,0,0,0], 2.0, 60)")}) {
        ScriptBench bench;
        UrController& c = bench.controller;
        c.run_script("def m():\n  " + motion + "\nend\n");
        bench.run(0.5);
        if (protective)
          c.protective_stop(157, "test");
        else
          EXPECT_TRUE(c.pause_program());
        bench.run(until_stopped);
        c.stop_program();
        bench.run(5.1);
        const Joints held = c.plant().q;
        EXPECT_EQ(c.unlock_protective_stop(), protective);
        bench.run(2.0);
        EXPECT_EQ(c.plant().q, held) << motion << ", " << protective << ", " << until_stopped;
        EXPECT_LT(held[0] - ScriptBench::start()[0], 0.3) << motion;
      }
}

TEST(UrMotion, PausingAndResumingAreStatesOfTheirOwn) {
  ScriptBench bench;
  UrController& c = bench.controller;
  c.run_script("def m():\n  movej([1,-1.3,1.6,-1.8,-1.5,0.2])\nend\n");
  bench.run(0.4);
  EXPECT_TRUE(c.pause_program());
  EXPECT_FALSE(c.pause_program()) << "it is pausing already";
  int braking = 0;
  for (; braking < 100; ++braking) {
    const Joints q = c.plant().q;
    bench.run(c.period());
    if (c.runtime() != RuntimeState::kPausing) break;
    ASSERT_NE(c.plant().q, q) << "the arm is still being braked";
    EXPECT_FALSE(c.program_running());
  }
  EXPECT_EQ(c.runtime(), RuntimeState::kPaused);
  EXPECT_NEAR(braking * c.period(), 0.2, 0.02);
  const Joints held = c.plant().q;
  bench.run(0.5);
  EXPECT_EQ(c.plant().q, held);
  EXPECT_TRUE(c.resume_program());
  EXPECT_TRUE(c.program_running());
  EXPECT_FALSE(c.resume_program()) << "it runs";
  bench.run(c.period());
  EXPECT_EQ(c.runtime(), RuntimeState::kResuming);
  EXPECT_NE(c.plant().q, held);
  bench.run(c.period());
  EXPECT_EQ(c.runtime(), RuntimeState::kPlaying);
}

TEST(UrMotion, WatchdogStopsWithinItsTime) {
  ScriptBench bench;
  bench.controller.run_script(
      "def s():\n  rtde_set_watchdog(\"input_int_register_24\", 10, \"stop\")\n"
      "  speedj([0.2,0,0,0,0,0], 1.0, 30)\nend\n");
  for (int k = 0; k < 20; ++k) {  // fed at 20 Hz
    bench.run(0.048);
    bench.controller.input_written("input_int_register_24");
    bench.controller.input_written("input_int_register_25");
  }
  EXPECT_TRUE(bench.controller.program_running());
  const double last = bench.controller.uptime();
  while (bench.controller.program_running() && bench.controller.uptime() < last + 1)
    bench.run(bench.controller.period());
  EXPECT_NEAR(bench.controller.uptime() - last, 0.1, 2 * bench.controller.period());
  bench.run(0.2);
  EXPECT_FALSE(bench.controller.motion.moving());
  EXPECT_THAT(bench.keys, HasSubstr("PROGRAM_XXX_STOPPED:s"));

  ScriptBench paused;
  paused.controller.run_script(
      "def s():\n  rtde_set_watchdog(\"input_int_register_24\", 10)\n"
      "  sleep(0.5)\n  textmsg(\"end\")\nend\n");
  paused.run(1.0);
  EXPECT_EQ(paused.controller.runtime(), RuntimeState::kPaused);
  EXPECT_EQ(paused.texts, "");
}

TEST(UrMotion, SpeedSliderAndPauseStretchTime) {
  const auto seconds = [](double slider) {
    ScriptBench bench;
    bench.controller.speed_slider = slider;
    bench.run(1.0);
    Joints goal = ScriptBench::start();
    goal[0] += 0.5;
    bench.controller.run_script("def m():\n  movej(" + list(goal) + ")\nend\n");
    bench.run(bench.controller.period());
    return bench.run_to_end(20.0);
  };
  const double full = seconds(1.0);
  EXPECT_NEAR(seconds(0.5), 2 * full, 0.05);
  EXPECT_NEAR(seconds(0.0), 20.0, 0.01) << "it never comes";

  ScriptBench bench;
  bench.controller.run_script("def m():\n  movej([1,-1.3,1.6,-1.8,-1.5,0.2])\nend\n");
  bench.run(0.4);
  EXPECT_TRUE(bench.controller.pause_program());
  bench.run(0.5);
  const Joints held = bench.controller.plant().q;
  bench.run(0.5);
  EXPECT_EQ(bench.controller.plant().q, held);
  EXPECT_TRUE(bench.controller.resume_program());
  bench.run_to_end();
  EXPECT_NEAR(bench.controller.plant().q[0], 1.0, 1e-9);
}

TEST(UrMotion, ForcesLoseThePayloadsWeight) {
  ScriptBench bench;
  bench.plant.set_wrench({0, 0, -2.0 * 9.81}, {0, 0, 0});
  bench.run(0.1);
  EXPECT_NEAR(bench.controller.wrench()[2], -2.0 * 9.81, 1e-9);
  bench.output("def p():\n  set_payload(2.0, [0,0,0])\n  sync()\n  sync()\n  textmsg(force() < 1e-9)\nend\n");
  EXPECT_EQ(bench.texts, "True");
  bench.plant.set_wrench({3, 0, -2.0 * 9.81}, {0, 0, 0});
  bench.run(0.1);
  EXPECT_NEAR(bench.controller.wrench()[0], -3.0, 1e-9) << "axes of the controller's base";
  bench.output("def p():\n  zero_ftsensor()\nend\n");
  EXPECT_LT(bench.controller.wrench().norm(), 1e-9);
}

TEST(UrMotion, ForceModeYieldsAlongItsAxisOnly) {
  ScriptBench bench;
  bench.plant.set_wrench({0, 0, 0}, {0, 0, 0});
  const Pose begin = bench.controller.motion.geometry().T_B_P(ScriptBench::start());
  bench.controller.run_script(
      "def f():\n"
      "  force_mode(p[0,0,0,0,0,0],[0,0,1,0,0,0],[0,0,-10,0,0,0],2,[0.1,0.1,0.05,1,1,1])\n"
      "  sleep(1.0)\n  end_force_mode()\n  sleep(0.5)\nend\n");
  bench.run(1.0);
  const Pose now = bench.controller.motion.geometry().T_B_P(bench.controller.plant().q);
  EXPECT_LT(now.translation().z(), begin.translation().z() - 0.01) << "pushes down while nothing resists";
  EXPECT_LT((now.translation() - begin.translation()).head<2>().norm(), 1e-6);
  bench.run(0.3);
  const Joints held = bench.controller.plant().q;
  bench.run(0.2);
  EXPECT_LT((bench.controller.plant().q - held).norm(), 1e-12);

  ScriptBench balanced;
  balanced.plant.set_wrench({0, 0, 10}, {0, 0, 0});
  balanced.run(0.1);
  balanced.controller.run_script(
      "def f():\n  force_mode(p[0,0,0,0,0,0],[0,0,1,0,0,0],[0,0,-10,0,0,0],2,"
      "[0.1,0.1,0.05,1,1,1])\n  sleep(0.5)\nend\n");
  balanced.run(0.5);
  EXPECT_LT((balanced.controller.plant().q - ScriptBench::start()).norm(), 1e-9);
}

TEST(UrMotion, TwoThreadsMayNotMoveAtOnce) {
  ScriptBench bench;
  bench.output(
      "def m():\n  thread t():\n    movej([1,-1.3,1.6,-1.8,-1.5,0.2])\n  end\n  run t()\n"
      "  sleep(0.1)\n  movej([0,-1.3,1.6,-1.8,-1.5,0.2])\nend\n");
  EXPECT_THAT(bench.exceptions, HasSubstr("Another thread is already controlling the robot"));
}

TEST(UrMotion, MovecRunsThroughItsViaPoint) {
  ScriptBench bench;
  const auto& geometry = bench.controller.motion.geometry();
  const Pose begin = geometry.T_B_P(ScriptBench::start());
  bench.controller.run_script(
      "def m():\n  a = get_actual_tcp_pose()\n"
      "  movec(pose_trans(a, p[0.05,0.05,0,0,0,0]), pose_trans(a, p[0.1,0,0,0,0,0]), v=0.1)\n"
      "end\n");
  double nearest = 1;
  const Eigen::Vector3d via = begin * Eigen::Vector3d(0.05, 0.05, 0);
  const Eigen::Vector3d centre = begin * Eigen::Vector3d(0.05, 0, 0);
  for (int k = 0; k < 1000 && (k < 2 || bench.controller.program_running()); ++k) {
    bench.run(bench.controller.period());
    const Eigen::Vector3d p = geometry.T_B_P(bench.controller.plant().q).translation();
    nearest = std::min(nearest, (p - via).norm());
    ASSERT_NEAR((p - centre).norm(), 0.05, 1e-6);
  }
  EXPECT_LT(nearest, 1e-3);
  EXPECT_NEAR((geometry.T_B_P(bench.controller.plant().q).translation() - begin.translation()).norm(), 0.1,
              1e-6);
}

}  // namespace
}  // namespace stonestack::emulators
