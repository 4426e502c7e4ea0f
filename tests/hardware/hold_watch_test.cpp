#include "hardware/hold_watch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

using Status = MotionResult::Status;

/// Moves for `seconds`, or until it is stopped.
struct SlowArm : Arm {
  double seconds = 1.0;
  bool safety_stop = false;  ///< the safety system ends the motion
  bool paused = false;       ///< it stands
  bool obeys = true;         ///< it confirms a stop
  std::atomic<bool> stopped{false};
  ArmState state() override {
    ArmState state;
    state.q[0] = 0.5;
    if (!stopped && !paused) state.qd[1] = 0.2;
    state.can_move = !safety_stop;
    return state;
  }
  MotionResult follow(const JointTrajectory& /*trajectory*/) override {
    const Stopwatch watch;
    while (watch.seconds() < seconds && !stopped) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    const bool ended = stopped || safety_stop;
    return {ended ? Status::kStopped : Status::kDone, Joints::Zero(), 0.0, ended ? "stopped" : ""};
  }
  MotionResult follow_guarded(const GuardedMotion& motion) override { return follow(motion.trajectory); }
  void stop() override {
    stopped = true;
    if (!obeys) throw DeviceError("arm", "does not stand 2 s after a stop", "press the emergency stop");
  }
  void set_payload(double /*mass*/, const Eigen::Vector3d& /*p_F_com*/) override {}
};

/// Answers by a list, and then the last of it again; 'h': holds, '-': does not, '?': no answer, 'm': the
/// fingers move, 'c': and have closed by 20 mm.
struct AnsweringGripper : Gripper {
  std::string answers;
  std::size_t asked = 0;
  explicit AnsweringGripper(std::string list) : answers(std::move(list)) {}
  GripperState state() override {
    const char answer = answers[std::min(asked++, answers.size() - 1)];
    if (answer == '?') throw DeviceError("gripper", "does not answer", "look at the cable");
    GripperState state;
    state.object = answer == 'h';
    state.moving = answer == 'm' || answer == 'c';
    state.opening = answer == 'c' ? 0.06 : 0.08;
    return state;
  }
  GripperState move(double, double, double) override { return {}; }
  void spread(double) override {}
};

MotionResult carried(const std::string& answers, SlowArm& arm) {
  AnsweringGripper gripper(answers);
  return HoldWatch(arm, gripper).carry({});
}

TEST(HoldWatch, AnObjectThatIsLostStopsTheArm) {
  SlowArm arm;
  arm.seconds = 20.0;
  const Stopwatch watch;
  const MotionResult result = carried("hh--", arm);
  EXPECT_EQ(result.status, Status::kDropped);
  EXPECT_THAT(result.reason, testing::HasSubstr("no longer holds"));
  EXPECT_TRUE(arm.stopped);
  EXPECT_EQ(result.q[0], 0.5) << "where the arm stands now";
  EXPECT_LT(watch.seconds(), 10.0);
}

TEST(HoldWatch, FingersThatCloseOnHaveLostIt) {
  SlowArm arm;
  arm.seconds = 20.0;
  EXPECT_EQ(carried("hmc", arm).status, Status::kDropped) << "before they have come to rest";
}

TEST(HoldWatch, AnObjectThatIsLostBeforeTheCarryStopsItToo) {
  SlowArm arm;
  arm.seconds = 20.0;
  EXPECT_EQ(carried("-", arm).status, Status::kDropped);
}

TEST(HoldWatch, OneOddAnswerOrNoneEndsNothing) {
  for (const char* answers : {"hh-h", "h????", "h-h?-h", "-h", "?", "hmmh", "hm"}) {
    SlowArm arm;
    EXPECT_EQ(carried(answers, arm).status, Status::kDone) << answers;
    EXPECT_FALSE(arm.stopped) << answers;
  }
}

TEST(HoldWatch, APersonMayTakeTheObjectOutOfAPausedArm) {
  SlowArm arm;
  arm.paused = true;
  EXPECT_EQ(carried("h--", arm).status, Status::kDone);
  EXPECT_FALSE(arm.stopped) << "nothing is commanded while somebody is at the gripper";
}

TEST(HoldWatch, AStopOfTheSafetySystemStaysOne) {
  SlowArm arm;
  arm.safety_stop = true;
  const MotionResult result = carried("h--", arm);
  EXPECT_EQ(result.status, Status::kStopped) << "it needs a person, whatever the gripper holds";
}

TEST(HoldWatch, AnArmThatDoesNotConfirmItsStopIsNotMovedOn) {
  SlowArm arm;
  arm.seconds = 20.0;
  arm.obeys = false;
  const MotionResult result = carried("hh--", arm);
  EXPECT_EQ(result.status, Status::kStopped) << "it needs a person";
  EXPECT_THAT(result.reason, testing::HasSubstr("does not stand 2 s after a stop"));
}

TEST(HoldWatch, OtherMotionsAreNotWatched) {
  SlowArm arm;
  AnsweringGripper gripper("h-");
  HoldWatch watch(arm, gripper);
  EXPECT_EQ(watch.follow({}).status, Status::kDone);
  EXPECT_EQ(gripper.asked, 0U);
}

}  // namespace
}  // namespace stonestack::hardware
