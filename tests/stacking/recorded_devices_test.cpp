#include "stacking/recorded_devices.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "rooms.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::test {
namespace {

/// Time that devices let pass.
struct TestClock : Clock {
  double seconds = 100.0;
  [[nodiscard]] double now() const override { return seconds; }
};

/// Arm on the clock: follows a trajectory to its end, or to where a guarded motion touches.
struct TestArm : Arm {
  TestClock& clock;
  Joints q = Joints::Zero();
  double contact_after = 1e9;                                 ///< of a guarded motion [s]
  double share = 1.0;                                         ///< of a free motion that is followed
  MotionResult::Status status = MotionResult::Status::kDone;  ///< that a free motion reports
  bool stopped = false, dead = false;
  explicit TestArm(TestClock& c) : clock(c) {}
  ArmState state() override {
    ArmState state;
    state.q = q;
    return state;
  }
  MotionResult move(const JointTrajectory& trajectory, double seconds, MotionResult::Status end) {
    clock.seconds += seconds;
    q = sample(trajectory, seconds).q;
    return {end, q, end == MotionResult::Status::kContact ? 12.0 : 0.0, ""};
  }
  MotionResult follow(const JointTrajectory& trajectory) override {
    return move(trajectory, share * trajectory.duration(), status);
  }
  double carried_for = 1e9;  ///< time after which the gripper has lost what it holds [s]
  MotionResult carry(const JointTrajectory& trajectory) override {
    return move(trajectory, carried_for, MotionResult::Status::kDropped);
  }
  MotionResult follow_guarded(const GuardedMotion& motion) override {
    return move(motion.trajectory, contact_after, MotionResult::Status::kContact);
  }
  void stop() override {
    stopped = true;
    if (dead) throw DeviceError("arm", "no data", "look at the cable");
  }
  void set_payload(double, const Eigen::Vector3d&) override {}
};

struct TestGripper : Gripper {
  TestClock& clock;
  explicit TestGripper(TestClock& c) : clock(c) {}
  GripperState state() override { return {}; }
  GripperState move(double opening, double, double) override {
    clock.seconds += 1.0;
    GripperState state;
    state.opening = opening;
    state.object = opening < 0.1;
    return state;
  }
  void spread(double) override {}
};

struct TestSensor : ForceTorqueSensor {
  double wrong = 0.0;  ///< added to a reading [N]
  Wrench read() override {
    Wrench wrench;
    wrench.force = {3.0 + wrong, 0.0, -4.0};
    return wrench;
  }
  void zero() override {}
};

struct TestCamera : DepthCamera {
  DepthFrame frame;
  TestCamera() {
    frame.image.z.assign(1000, 0.6F);
    frame.number = 1;
    frame.device_time = 1.0;
  }
  DepthFrame capture() override { return frame; }
};

JointTrajectory ramp(double seconds) {
  JointTrajectory trajectory;
  trajectory.time = {0.0, seconds};
  trajectory.q = {Joints::Zero(), Joints::Constant(seconds)};
  trajectory.qd = {Joints::Ones(), Joints::Ones()};
  return trajectory;
}

class RecordedDevicesTest : public ::testing::Test {
 protected:
  TestClock clock_;
  TestArm arm_{clock_};
  TestGripper gripper_{clock_};
  TestSensor sensor_;
  TestCamera camera_;
  Cell inner_{arm_, gripper_, sensor_, camera_, clock_, {}};
  Timeline timeline_;
  RecordedDevices devices_{inner_, timeline_};
};

TEST_F(RecordedDevicesTest, SamplesAMotionAlongItsTime) {
  EXPECT_EQ(devices_.cell().arm.follow(ramp(2.0)).status, MotionResult::Status::kDone);
  ASSERT_GE(timeline_.samples.size(), 20u);
  EXPECT_NEAR(timeline_.samples.front().time, 100.0, 1e-9);
  EXPECT_NEAR(timeline_.samples.back().time, 102.0, 1e-9);
  for (const MotionSample& s : timeline_.samples) EXPECT_NEAR(s.q[3], s.time - 100.0, 1e-9);
}

TEST_F(RecordedDevicesTest, ACarryThatEndsEarlyIsRecordedUpToThere) {
  arm_.carried_for = 0.5;
  const MotionResult result = devices_.cell().arm.carry(ramp(2.0));
  EXPECT_EQ(result.status, MotionResult::Status::kDropped);
  EXPECT_NEAR(timeline_.samples.back().q[0], result.q[0], 1e-12);
  EXPECT_NEAR(result.q[0], 0.5, 1e-9);
  EXPECT_NO_THROW((void)devices_.cell().arm.state()) << "it stands where the carry ended";
}

TEST_F(RecordedDevicesTest, EndsAGuardedMotionWhereItTouched) {
  arm_.contact_after = 0.35;
  GuardedMotion motion;
  motion.trajectory = ramp(2.0);
  EXPECT_EQ(devices_.cell().arm.follow_guarded(motion).status, MotionResult::Status::kContact);
  const MotionSample& last = timeline_.samples.back();
  EXPECT_NEAR(last.time, 100.35, 1e-9);
  EXPECT_NEAR(last.q[0], 0.35, 1e-9);
  EXPECT_DOUBLE_EQ(last.force, 12.0);
}

TEST_F(RecordedDevicesTest, RefusesJointsThatCannotBe) {
  Arm& arm = devices_.cell().arm;
  EXPECT_NO_THROW((void)arm.state());
  for (const double wrong : {std::nan(""), HUGE_VAL, 1e30, 8.0}) {
    arm_.q[2] = wrong;
    EXPECT_THROW((void)arm.state(), DeviceError) << wrong;
  }
}

TEST_F(RecordedDevicesTest, RefusesAnArmThatMovedWithoutACommand) {
  Arm& arm = devices_.cell().arm;
  EXPECT_EQ(arm.follow(ramp(1.0)).status, MotionResult::Status::kDone);
  arm_.q[1] += 0.02;  // settled
  EXPECT_NO_THROW((void)arm.state());
  arm_.q[1] += 0.5;
  EXPECT_THROW((void)arm.state(), DeviceError);
}

TEST_F(RecordedDevicesTest, AMotionThatIsDoneElsewhereThanAtItsEndIsAStop) {
  Arm& arm = devices_.cell().arm;
  arm_.share = 0.97;  // within what arms are exact at rest
  EXPECT_EQ(arm.follow(ramp(1.0)).status, MotionResult::Status::kDone);
  arm_.share = 0.5;
  const MotionResult done = arm.follow(ramp(1.0));
  EXPECT_EQ(done.status, MotionResult::Status::kStopped);
  EXPECT_THAT(done.reason, testing::HasSubstr("stands 0.5 rad from its end"));
}

TEST_F(RecordedDevicesTest, StopsAnArmThatIsLostInAMotion) {
  Arm& arm = devices_.cell().arm;
  arm_.share = 0.5;
  arm_.status = MotionResult::Status::kStopped;
  EXPECT_EQ(arm.follow(ramp(1.0)).status, MotionResult::Status::kStopped);
  EXPECT_FALSE(arm_.stopped) << "a controller that has stopped needs no command";
  arm_.status = MotionResult::Status::kLost;
  EXPECT_EQ(arm.follow(ramp(1.0)).status, MotionResult::Status::kLost);
  EXPECT_TRUE(arm_.stopped) << "the controller may have got the motion";
  arm_.dead = true;
  EXPECT_THAT(arm.follow(ramp(1.0)).reason, testing::HasSubstr("did not confirm a stop: arm: no data"));
}

TEST_F(RecordedDevicesTest, RefusesForcesThatCannotBe) {
  ForceTorqueSensor& sensor = devices_.cell().force_torque;
  EXPECT_NO_THROW((void)sensor.read());
  for (const double wrong : {std::nan(""), HUGE_VAL, 1e30}) {
    sensor_.wrong = wrong;
    EXPECT_THROW((void)sensor.read(), DeviceError) << wrong;
  }
}

TEST_F(RecordedDevicesTest, RefusesAFrozenFrame) {
  DepthCamera& camera = devices_.cell().camera;
  EXPECT_NO_THROW((void)camera.capture());
  EXPECT_THROW((void)camera.capture(), DeviceError);
  ++camera_.frame.number;
  camera_.frame.device_time += 0.1;
  EXPECT_NO_THROW((void)camera.capture());
}

TEST_F(RecordedDevicesTest, RefusesFramesWithoutDepth) {
  for (const float depth : {0.0F, std::nanf(""), 600.0F}) {
    ++camera_.frame.number;
    camera_.frame.image.z.assign(1000, depth);
    EXPECT_THROW((void)devices_.cell().camera.capture(), DeviceError) << depth;
  }
}

TEST_F(RecordedDevicesTest, KnowsFromWhenToWhenAnObjectIsHeld) {
  Cell cell = devices_.cell();
  cell.gripper.move(0.06, 0.1, 30.0);
  EXPECT_FALSE(timeline_.samples.front().holds);
  EXPECT_TRUE(timeline_.samples.back().holds);
  EXPECT_DOUBLE_EQ(timeline_.samples.back().opening, 0.06);
  (void)cell.force_torque.read();
  EXPECT_DOUBLE_EQ(timeline_.samples.back().force, 5.0);
  cell.gripper.move(0.155, 0.1, 30.0);
  EXPECT_FALSE(timeline_.samples.back().holds);
}

TEST_F(RecordedDevicesTest, TimeNeverRunsBackwards) {
  Cell cell = devices_.cell();
  (void)cell.arm.follow(ramp(1.0));
  clock_.seconds -= 0.5;  // a clock that jumps
  (void)cell.force_torque.read();
  for (std::size_t i = 1; i < timeline_.samples.size(); ++i)
    EXPECT_GE(timeline_.samples[i].time, timeline_.samples[i - 1].time);
}

}  // namespace
}  // namespace stonestack::test
