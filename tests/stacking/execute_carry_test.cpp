#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "stacking/scripted_cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::stacking {
namespace {

using scripted::Kind;
using Status = MotionResult::Status;

/// A stone of 1 kg is lifted, carried, lowered and set down; `carried_masses` is the part of it that the
/// wrist measures after the lift, the carry and the lowering.
struct Carried : scripted::Bench {
  std::vector<double> carried_masses;
  std::vector<double> beside;  ///< horizontal distance from the planned line of action [m]; empty: 0

  explicit Carried(std::vector<double> felt) : carried_masses(std::move(felt)) {
    PlanStep lift, carry;
    lift.kind = Kind::kLift;
    carry.kind = Kind::kTransit;
    carry.trajectory.time = {0.0, 1.0};
    carry.trajectory.q = {arm.q, arm.q + Joints::Constant(0.1)};
    carry.trajectory.qd = {Joints::Zero(), Joints::Zero()};
    plan.steps[0] = carry;
    plan.steps.insert(plan.steps.begin(), lift);
    arm.after_motion = [this] {
      const Eigen::Matrix3d R_W_F = (layout.T_W_R * forward(scene.robot, arm.q)).linear();
      const double mass = carried_masses[std::min(carried_masses.size(), arm.commands.size()) - 1];
      force.wrench.force = R_W_F.transpose() * Eigen::Vector3d(0, 0, -9.81 * mass);
      const std::size_t motions = arm.commands.size();
      const Eigen::Vector3d p_W_beside(motions <= beside.size() ? beside[motions - 1] : 0.0, 0, 0);
      const Eigen::Vector3d p_F = layout.T_F_T.translation() + R_W_F.transpose() * p_W_beside;
      force.wrench.torque = p_F.cross(force.wrench.force);
    };
  }
  ExecutionResult run() { return Bench::run({Status::kNoContact, Status::kContact}); }
};

TEST(Execute, AStoneLostInTransitIsNotSetDown) {
  Carried cell({1.0, 0.0});
  const auto done = cell.run();
  EXPECT_EQ(done.status, ExecutionResult::Status::kLost);
  EXPECT_THAT(done.reason, testing::HasSubstr("lost in transit"));
  EXPECT_THAT(cell.arm.commands, testing::ElementsAre("follow", "follow", "follow", "open"));
  const JointTrajectory& carry = cell.plan.steps[1].trajectory;
  EXPECT_EQ(cell.arm.followed.q.front(), carry.q.back()) << "back as it came";
  EXPECT_EQ(cell.arm.followed.q.back(), carry.q.front());
}

TEST(Execute, AStoneLostOnTheWayIsCarriedNoFurther) {
  Carried cell({1.0, 0.0});
  const JointTrajectory& carry = cell.plan.steps[1].trajectory;
  cell.arm.dropped_at = sample(carry, 0.4).q;
  const auto done = cell.run();
  EXPECT_EQ(done.status, ExecutionResult::Status::kLost);
  EXPECT_THAT(done.reason, testing::HasSubstr("lost in transit"));
  EXPECT_THAT(cell.arm.commands, testing::ElementsAre("follow", "carry", "follow", "open"));
  EXPECT_EQ(cell.arm.followed.q.front(), sample(carry, 0.4).q) << "back from where the arm stands";
  EXPECT_TRUE(cell.arm.followed.q.back().isApprox(carry.q.front()));
  const double carried = (sample(carry, 0.4).q - carry.q.front()).norm();
  for (const Joints& q : cell.arm.followed.q)
    EXPECT_LT((q - carry.q.front()).norm(), carried + 1e-6) << "not beyond where it was";
  EXPECT_EQ(cell.arm.payloads.size(), 2U) << "the arm knows at once that nothing is carried any more";
}

TEST(Execute, AStoneThatTheWristStillWeighsIsPutBack) {
  Carried cell({1.0, 1.0});
  cell.arm.dropped_at = sample(cell.plan.steps[1].trajectory, 0.4).q;
  const auto done = cell.Bench::run({Status::kContact});
  EXPECT_EQ(done.status, ExecutionResult::Status::kNotPicked);
  EXPECT_THAT(done.reason, testing::HasSubstr("uncertain in transit"));
  EXPECT_THAT(cell.arm.commands,
              testing::ElementsAre("follow", "carry", "follow", "lower", "follow", "open", "follow"));
  EXPECT_EQ(cell.arm.payloads.size(), 1U) << "until then the arm carries it";
}

TEST(Execute, AStoneThatFallsWhileItIsLoweredIsNotSetDown) {
  Carried cell({1.0, 1.0, 0.0});
  EXPECT_EQ(cell.run().status, ExecutionResult::Status::kLost);
  EXPECT_THAT(cell.arm.commands,
              testing::ElementsAre("follow", "follow", "lower", "follow", "follow", "open"));
}

TEST(Execute, AStopOnTheReturnWithAnEmptyGripperEndsIt) {
  Carried cell({1.0, 0.0});
  cell.arm.stops_after = 2;
  EXPECT_EQ(cell.run().status, ExecutionResult::Status::kStopped);
  EXPECT_THAT(cell.arm.commands, testing::ElementsAre("follow", "follow", "follow"))
      << "nothing after a stop";
}

TEST(Execute, AStoneThatTurnedInTheGripperIsBroughtBack) {
  Carried cell({1.0, 1.0});
  cell.beside = {0.0, 0.07, 0.07, 0.07, 0.07, 0.07};
  const auto done = cell.Bench::run({Status::kContact});
  EXPECT_EQ(done.status, ExecutionResult::Status::kNotPicked);
  EXPECT_THAT(done.reason, testing::HasSubstr("turned in the gripper: its load acts 70 mm beside"));
  // Lifted, carried, back, down until it touches, a little up so that the fingers can open, and away.
  EXPECT_THAT(cell.arm.commands,
              testing::ElementsAre("follow", "follow", "follow", "lower", "follow", "open", "follow"));
}

TEST(Execute, AStoneThatTurnedInTheGripperIsPutBackSlowly) {
  Carried cell({1.0, 1.0});
  cell.beside = {0.07, 0.07, 0.07, 0.07};
  JointTrajectory& lift = cell.plan.steps[0].trajectory;
  lift.time = {0.0, 0.5};
  lift.q = {cell.arm.q + Joints::Unit(1) * 0.1, cell.arm.q};
  lift.qd = {Joints::Zero(), Joints::Zero()};
  const auto height = [&](const Joints& q) {
    return (cell.layout.T_W_R * forward(cell.scene.robot, q) * cell.scene.T_F_T).translation().z();
  };
  double fastest = 0.0, lowered = 0.0;
  cell.arm.mean_force = [&](const GuardedMotion& down) {
    const JointTrajectory& way = down.trajectory;
    for (std::size_t k = 1; k < way.q.size(); ++k)
      fastest =
          std::max(fastest, (height(way.q[k - 1]) - height(way.q[k])) / (way.time[k] - way.time[k - 1]));
    lowered = height(way.q.front()) - height(way.q.back());
    return 0.0;
  };
  EXPECT_THAT(cell.Bench::run({Status::kContact}).reason, testing::HasSubstr("turned in the gripper"));
  EXPECT_GT(lowered, 0.05) << "all the way that it was lifted";
  EXPECT_GT(fastest, 0.03);
  EXPECT_LE(fastest, 0.051) << "it may hang lower than it lay, and a guard hears of a contact late";
}

/// Lowered, the stone touches something that bears a part of it; raised, it weighs `raised` kg.
struct Touching : Carried {
  explicit Touching(double lowered, double raised) : Carried({1.0, 1.0, lowered, raised, raised, 0.0}) {
    beside = {0.0, 0.0, 0.07};
    Joints lower = arm.q;
    lower[1] += 0.1;
    for (const std::size_t step : {2, 3}) {
      plan.steps[step].trajectory.time = {0.0, 1.0};
      plan.steps[step].trajectory.q = {step == 2 ? arm.q : lower, lower};
      plan.steps[step].trajectory.qd = {Joints::Zero(), Joints::Zero()};
    }
    gripper.object = true;
  }
};

TEST(Execute, AStoneThatTouchedWhileItWasLoweredIsSetDownFromHigher) {
  for (const double lowered : {0.75, -0.05}) {  // a part of it is borne, and all of it
    Touching cell(lowered, 1.0);
    cell.plan.steps.erase(cell.plan.steps.begin() + 4, cell.plan.steps.end());  // what lets go
    const auto done = cell.Bench::run({Status::kNoContact, Status::kContact});
    EXPECT_EQ(done.status, ExecutionResult::Status::kReleased) << done.reason;
    EXPECT_THAT(done.reason, testing::HasSubstr("early contact"));
    EXPECT_THAT(cell.arm.commands, testing::ElementsAre("follow", "follow", "lower", "follow", "descend"));
  }
}

TEST(Execute, AStoneThatWeighsNothingWhenItIsRaisedAgainHasNotTouched) {
  Touching cell(0.0, 0.0);  // the wrist is dead
  const auto done = cell.Bench::run({Status::kNoContact, Status::kContact});
  EXPECT_EQ(done.status, ExecutionResult::Status::kNotPicked) << done.reason;
  EXPECT_THAT(done.reason, testing::HasSubstr("the wrist measures 0"));
}

TEST(Execute, AStoneThatPullsALittleBesideIsSetDown) {
  Carried cell({1.0});
  cell.beside = {0.0, 0.015, 0.015};
  cell.plan.steps.erase(cell.plan.steps.begin() + 4, cell.plan.steps.end());  // what lets go
  EXPECT_EQ(cell.run().status, ExecutionResult::Status::kReleased);
}

TEST(Execute, TheGripperDecidesWhereTheWristIsUncertain) {
  const auto ends = [](double carried_masses, bool object, int moving = 0) {
    Carried cell({1.0, carried_masses});
    cell.gripper.object = object;
    cell.gripper.moving = moving;
    cell.arm.commands.clear();
    cell.plan.steps.erase(cell.plan.steps.begin() + 4, cell.plan.steps.end());  // what lets go
    return cell.run().status;
  };
  using End = ExecutionResult::Status;
  EXPECT_EQ(ends(0.9, true), End::kReleased);
  EXPECT_EQ(ends(0.9, false), End::kReleased) << "something as heavy is held";
  EXPECT_EQ(ends(0.4, true), End::kReleased) << "slipped, and still held";
  EXPECT_EQ(ends(0.4, true, 3), End::kReleased) << "the fingers close on what slips";
  EXPECT_EQ(ends(0.4, false), End::kLost);
}

TEST(Execute, AStoneThatTheGripperHoldsIsNotDroppedForADeadWrist) {
  Carried cell({1.0, 0.0});
  cell.gripper.object = true;
  const auto done = cell.Bench::run({Status::kContact});
  EXPECT_EQ(done.status, ExecutionResult::Status::kNotPicked);
  EXPECT_THAT(done.reason, testing::HasSubstr("the gripper reports an object, and the wrist measures 0"));
  EXPECT_THAT(cell.arm.commands,
              testing::ElementsAre("follow", "follow", "follow", "lower", "follow", "open", "follow"))
      << "back, and down until it touches, before the fingers open";
}

TEST(Execute, AGripperMayReportLateThatItHoldsNothing) {
  Carried cell({1.0, 0.0});
  cell.gripper.object = true;
  const auto after_motion = cell.arm.after_motion;
  cell.arm.after_motion = [&] {
    after_motion();
    cell.gripper.object = cell.arm.commands.size() < 3;
  };
  EXPECT_EQ(cell.run().status, ExecutionResult::Status::kLost);
  EXPECT_THAT(cell.arm.commands, testing::ElementsAre("follow", "follow", "follow", "open"));
}

}  // namespace
}  // namespace stonestack::stacking
