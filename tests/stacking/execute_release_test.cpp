#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "stacking/scripted_cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::stacking {
namespace {

using scripted::Kind;
using Status = MotionResult::Status;
using End = ExecutionResult::Status;

/// Picks a stone of 1 kg up and sets it down; `left` of it (kg) hangs in the gripper when it has opened by
/// `opens_at` (m), and when it has gone back.
struct Released : scripted::Bench {
  double left = 0.0, left_after_retreat = 0.0, opens_at = 0.0;
  double left_again = 0.0;  ///< of it (kg) hangs after it was set down a second time
  int slides_off = 1000;    ///< after so many free motions that follow that one
  double weighs = 1.0;      ///< the stone [kg]
  double beside = 0.0;      ///< where its load acts, along y of F from the tips [m]
  bool lifted = false, set_down_again = false;

  Released() {
    PlanStep open, grasp, lift;
    open.kind = Kind::kOpen;
    open.opening = 0.1;
    grasp.kind = Kind::kGrasp;
    lift.kind = Kind::kLift;
    plan.steps.insert(plan.steps.begin() + 1, {open, grasp, lift});
    for (PlanStep& step : plan.steps)
      if (step.kind == Kind::kRelease) step.opening = 0.1;
    gripper.object = true;
    arm.after_motion = [this] {
      const bool retreated = released && lifted;
      if (!released) lifted = std::count(arm.commands.begin(), arm.commands.end(), "follow") > 1;
      if (set_down_again && --slides_off < 0) left_again = 0.0;
      if (retreated && arm.commands.back() == "lower") set_down_again = true;
      hang(set_down_again ? left_again : retreated ? left_after_retreat : lifted ? weighs : 0.0);
    };
    gripper.after_move = [this](double opening) {
      gripper.object = opening <= 0.0;  // a gripper that opens never reports an object
      released = lifted && opening > 0.0;
      if (released) hang(set_down_again ? left_again : opening > opens_at ? left : weighs);
    };
  }
  void hang(double mass) {
    const Eigen::Matrix3d R_W_F = (layout.T_W_R * forward(scene.robot, arm.q)).linear();
    force.wrench.force = R_W_F.transpose() * Eigen::Vector3d(0, 0, -9.81 * mass);
    force.wrench.torque =
        (layout.T_F_T.translation() + Eigen::Vector3d(0, beside, 0)).cross(force.wrench.force);
  }
  /// The third guarded motion is that of a stone which is set down once more.
  ExecutionResult run() { return Bench::run({Status::kNoContact, Status::kContact, Status::kContact}); }
  ExecutionResult tip_over() {
    arm.guarded = {Status::kNoContact, Status::kContact, Status::kContact};
    return execute(plan, stone, scene, cell, {}, nullptr, LetGo::kTippedOver);
  }

  bool released = false;
};

TEST(ExecuteRelease, TheArmReceivesThePayloadWithAndWithoutTheStone) {
  Released cell;
  const auto done = cell.run();
  ASSERT_EQ(done.status, End::kReleased) << done.reason;
  const double gripper_mass = carried_mass(cell.scene.gripper);
  ASSERT_EQ(cell.arm.payloads.size(), 2u);
  EXPECT_NEAR(cell.arm.payloads[0], gripper_mass + 1.0, 1e-12) << "gripper, sensor, camera and stone";
  EXPECT_NEAR(cell.arm.payloads[1], gripper_mass, 1e-12);
  EXPECT_GT(gripper_mass, cell.scene.gripper.mass + 0.3) << "a sensor weighs 0.30 to 0.65 kg";
}

TEST(ExecuteRelease, AStoneThatTheArmRefusesStaysWhereItLies) {
  Released cell;
  cell.arm.max_payload = 4.0;
  const auto done = cell.run();
  EXPECT_EQ(done.status, End::kNotPicked);
  EXPECT_THAT(done.reason, testing::HasSubstr("the arm carries 4 kg"));
  EXPECT_EQ(cell.arm.commands.back(), "follow") << "closed, opened, and back out";
  EXPECT_THAT(cell.arm.commands, testing::Contains("open").Times(3));
}

TEST(ExecuteRelease, AStoneThatStaysAtAFingerEndsTheRunBeforeTheRetreat) {
  Released cell;
  cell.left = 1.0;
  const auto done = cell.run();
  EXPECT_EQ(done.status, End::kStopped);
  EXPECT_THAT(done.reason, testing::HasSubstr("not empty after release"));
  EXPECT_EQ(cell.arm.commands.back(), "open") << "once more, wide; nothing moves after it";
  EXPECT_EQ(cell.arm.payloads.back(), carried_mass(cell.scene.gripper) + 1.0) << "the arm holds it still";
}

TEST(ExecuteRelease, AFingerIsNotOpenedIntoTheTable) {
  const auto times_opened = [](double inclination) {
    Released cell;
    cell.left = 1.0;
    cell.scene.gripper = gripper_of(cell.layout);
    Pose T_W_T(Eigen::Translation3d(0.6, 0.0, 0.07));  // tool down, then inclined
    T_W_T.rotate(Eigen::AngleAxisd(inclination, Eigen::Vector3d::UnitY()));
    T_W_T.rotate(Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX()));
    const Pose T_R_T = forward(cell.scene.robot, cell.arm.q) * cell.scene.T_F_T;
    cell.layout.T_W_R = cell.cell.layout.T_W_R = T_W_T * T_R_T.inverse();
    EXPECT_EQ(cell.run().status, End::kStopped);
    return std::count(cell.arm.commands.begin(), cell.arm.commands.end(), "open");
  };
  EXPECT_EQ(times_opened(0.0), times_opened(1.2) + 1) << "the lower finger goes down as it opens";
}

/// A stone that tips over falls onto the fingers, and off them as they leave.
TEST(ExecuteRelease, AStoneThatIsTippedOverMayLeanOnTheFingersUntilTheyLeave) {
  Released cell;
  cell.left = 1.0;
  const auto done = cell.tip_over();
  EXPECT_EQ(done.status, End::kReleased) << done.reason;
  EXPECT_EQ(cell.arm.commands.back(), "follow");

  Released stuck;
  stuck.left = stuck.left_after_retreat = stuck.left_again = 1.0;
  const auto held = stuck.tip_over();
  EXPECT_EQ(held.status, End::kStopped);
  EXPECT_THAT(held.reason, testing::HasSubstr("not empty after release"));
}

TEST(ExecuteRelease, FingersAreDrawnOutFromBeneathAStoneThatFellOntoThem) {
  const auto fell_on_fingers = [](Released& cell) { cell.left_after_retreat = cell.left_again = 0.4; };
  Released cell;
  fell_on_fingers(cell);
  cell.slides_off = 3;  // the retreat, and three more
  const auto done = cell.tip_over();
  EXPECT_EQ(done.status, End::kReleased) << done.reason;
  const std::vector<std::string> end(cell.arm.commands.end() - 5, cell.arm.commands.end());
  EXPECT_THAT(end, testing::ElementsAre("open", "follow", "follow", "follow", "follow"));
  EXPECT_EQ(cell.arm.payloads.back(), carried_mass(cell.scene.gripper)) << "nothing is carried any more";

  Released over_tower;  // where it would fall onto other stones
  fell_on_fingers(over_tower);
  over_tower.slides_off = 3;
  EXPECT_EQ(over_tower.run().status, End::kStopped);

  Released walled;  // by something 80 mm behind the palm
  fell_on_fingers(walled);
  walled.slides_off = 3;
  const Pose T_W_F = walled.layout.T_W_R * forward(walled.scene.robot, walled.arm.q);
  walled.scene.T_W_R = walled.layout.T_W_R;
  walled.scene.objects.push_back(
      {"wall", {make_box({0.4, 0.4, 0.01})}, T_W_F * Eigen::Translation3d(0, 0, -0.16)});
  const auto held = walled.tip_over();
  EXPECT_EQ(held.status, End::kStopped);
  EXPECT_THAT(held.reason, testing::HasSubstr("not empty after release"));
}

/// Its model says 1 kg, by a density that is assumed.
TEST(ExecuteRelease, AStoneThatWasNeverWeighedIsWeighedWhenItIsLifted) {
  Released cell;
  cell.weighs = 0.25;
  const auto done = cell.tip_over();
  EXPECT_EQ(done.status, End::kReleased) << done.reason;
  ASSERT_TRUE(done.weight.has_value());
  EXPECT_NEAR(*done.weight, 0.25 * 9.81, 0.01);
  const double gripper_mass = carried_mass(cell.scene.gripper);
  ASSERT_GE(cell.arm.payloads.size(), 3U);
  EXPECT_NEAR(cell.arm.payloads[1], gripper_mass + 0.25, 1e-3) << "as soon as it is known";
  EXPECT_NEAR(cell.arm.payloads.back(), gripper_mass, 1e-12);

  Released swung;
  swung.weighs = 0.25;
  swung.beside = 0.06;
  const auto put_back = swung.tip_over();
  EXPECT_EQ(put_back.status, End::kNotPicked);
  EXPECT_NEAR(put_back.weight.value_or(0.0), 0.25 * 9.81, 0.01) << "it is known all the same";

  Released heavy;
  heavy.weighs = 3.0;
  heavy.arm.max_payload = gripper_mass + 2.0;
  const auto refused = heavy.tip_over();
  EXPECT_EQ(refused.status, End::kNotPicked);
  EXPECT_THAT(refused.reason, testing::HasSubstr("the arm carries"))
      << "put back, not held until somebody comes";
  EXPECT_NEAR(refused.weight.value_or(0.0), 3.0 * 9.81, 0.01);

  Released known;  // of a stone whose mass is known so much less is one that has slipped
  known.weighs = 0.25;
  EXPECT_EQ(known.run().status, End::kNotPicked);
}

TEST(ExecuteRelease, OpeningWiderMayFreeIt) {
  Released cell;
  cell.opens_at = 0.12;
  const auto done = cell.run();
  EXPECT_EQ(done.status, End::kReleased) << done.reason;
  EXPECT_EQ(cell.arm.commands.back(), "follow");
}

TEST(ExecuteRelease, AFaultThatPassesDoesNotEndTheRun) {
  Released cell;
  bool failed = false;
  cell.gripper.after_move = [&, then = cell.gripper.after_move](double opening) {
    if (cell.lifted && !std::exchange(failed, true))
      throw DeviceError("gripper", "minor fault", "look at the gripper");
    then(opening);
  };
  const auto done = cell.run();
  EXPECT_EQ(done.status, End::kReleased) << done.reason;
  EXPECT_TRUE(failed);
  EXPECT_TRUE(cell.released) << "opened by the repeated command";
}

/// Fingers at the end of their travel press on nothing; what hangs in the gripper all the same is weighed.
TEST(ExecuteRelease, AnObjectThatIsReportedAtFullOpeningIsNone) {
  const auto misreports = [](Released& cell, double widest) {
    cell.gripper.after_move = [&cell, widest, then = cell.gripper.after_move](double opening) {
      then(opening);
      cell.gripper.stands_at = std::min(opening, widest);
      cell.gripper.object = true;
    };
  };
  Released cell;
  misreports(cell, cell.scene.gripper.max_opening);
  const auto done = cell.run();
  EXPECT_EQ(done.status, End::kReleased) << done.reason;
  EXPECT_EQ(cell.arm.commands.back(), "follow");

  Released heavy;  // and comes along
  misreports(heavy, heavy.scene.gripper.max_opening);
  heavy.left_after_retreat = 1.0;
  heavy.left_again = 1.0;
  EXPECT_EQ(heavy.run().status, End::kStopped);

  Released jammed;
  misreports(jammed, 0.12);
  EXPECT_EQ(jammed.run().status, End::kStopped);
}

TEST(ExecuteRelease, AStoneThatComesAlongIsNotCarriedAround) {
  Released cell;  // it rested on the tower until the gripper went up
  cell.left_after_retreat = cell.left_again = 1.0;
  const auto done = cell.run();
  EXPECT_EQ(done.status, End::kStopped);
  EXPECT_THAT(done.reason, testing::HasSubstr("not empty after release"));
  EXPECT_EQ(cell.arm.payloads.back(), carried_mass(cell.scene.gripper) + 1.0) << "the arm holds it still";
}

TEST(ExecuteRelease, AStoneThatComesAlongIsSetDownOnceMore) {
  Released cell;
  cell.left_after_retreat = 1.0;
  const auto done = cell.run();
  EXPECT_EQ(done.status, End::kReleased) << done.reason;
  const std::vector<std::string> end(cell.arm.commands.end() - 3, cell.arm.commands.end());
  EXPECT_THAT(end, testing::ElementsAre("lower", "open", "follow"));
  EXPECT_DOUBLE_EQ(cell.gripper.stands_at, cell.scene.gripper.max_opening);
  EXPECT_EQ(cell.arm.payloads.back(), carried_mass(cell.scene.gripper)) << "nothing is carried any more";
}

TEST(ExecuteRelease, AStoneThatCannotBeSetDownOnceMoreStaysWhereItIs) {
  Released cell;
  cell.left_after_retreat = 1.0;
  const auto done =
      static_cast<scripted::Bench&>(cell).run({Status::kNoContact, Status::kContact, Status::kStopped});
  EXPECT_EQ(done.status, End::kStopped);
  EXPECT_THAT(done.reason, testing::HasSubstr("down once more: scripted"));
  EXPECT_EQ(cell.arm.commands.back(), "lower") << "nothing moves after a stop";
}

}  // namespace
}  // namespace stonestack::stacking
