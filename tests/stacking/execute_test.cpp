#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "kinematics/inverse.hpp"
#include "stacking/scripted_cell.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "temporary_folder.hpp"

namespace stonestack::stacking {
namespace {

using scripted::Bench;
using scripted::Kind;
using Status = MotionResult::Status;

TEST(Execute, DescendsUntilItTouchesAndLetsGo) {
  Bench bench;
  const auto done = bench.run({Status::kNoContact, Status::kContact});
  EXPECT_EQ(done.status, ExecutionResult::Status::kReleased);
  EXPECT_EQ(done.reason, "");
  EXPECT_EQ(done.contact_force, 7.0);
  EXPECT_THAT(bench.arm.commands, testing::ElementsAre("follow", "lower", "descend", "open", "follow"));
}

TEST(Execute, WritesWhereItTouched) {
  Bench bench;
  const std::string path = test::temporary_folder() + "touch.jsonl";
  std::filesystem::remove(path);
  Journal journal(path);
  JointTrajectory& descent = bench.plan.steps[2].trajectory;  // to 15 mm below where the arm will stand
  const Pose T_R_F = forward(bench.scene.robot, bench.arm.q);
  const Pose T_R_F_low = Eigen::Translation3d(0, 0, -0.015) * T_R_F;
  descent.time = {0.0, 1.0};
  descent.q = {bench.arm.q, inverse(bench.scene.robot, T_R_F_low, bench.arm.q).front().q};
  descent.qd = {Joints::Zero(), Joints::Zero()};
  bench.arm.guarded = {Status::kNoContact, Status::kContact};
  (void)execute(bench.plan, bench.stone, bench.scene, bench.cell, {}, &journal);
  std::istringstream lines(read_file(path, 10000));
  std::filesystem::remove(path);
  std::vector<nlohmann::json> touches;
  for (std::string line; std::getline(lines, line);)
    if (const auto entry = nlohmann::json::parse(line); entry.at("kind") == "touch")
      touches.push_back(entry.at("data"));
  ASSERT_EQ(touches.size(), 2U);
  EXPECT_EQ(touches[0].at("touched"), false);
  EXPECT_EQ(touches[1].at("touched"), true);
  EXPECT_EQ(touches[1].at("force"), 7.0);
  EXPECT_NEAR(touches[1].at("above_end_m").get<double>(), 0.015, 0.001);
}

/// Finger tips that come nearer to the table than the arm is exact stop at what they meet, and close a little
/// above it.
TEST(Execute, ApproachesAGraspNearTheTableByForce) {
  Bench bench;
  PlanStep approach, grasp;
  approach.kind = Kind::kApproach;
  approach.threshold = 20.0;
  grasp.kind = Kind::kGrasp;
  bench.plan.steps = {approach, grasp};
  bench.gripper.object = true;
  EXPECT_EQ(bench.run({Status::kContact}).status, ExecutionResult::Status::kReleased);
  EXPECT_THAT(bench.arm.commands, testing::ElementsAre("lower", "follow", "open"));
  EXPECT_EQ(bench.run({Status::kNoContact}).status, ExecutionResult::Status::kReleased);
  EXPECT_THAT(bench.arm.commands, testing::ElementsAre("lower", "open"));
  EXPECT_EQ(bench.run({Status::kStopped}).status, ExecutionResult::Status::kStopped);
  EXPECT_THAT(bench.arm.commands, testing::ElementsAre("lower"));
}

/// Fingers that felt the table close above where the plan grasps, and the arm refuses a motion that begins
/// elsewhere than it stands.
TEST(Execute, LiftsFromWhereTheFingersClosed) {
  Bench bench;
  const Joints q = bench.arm.q;
  const Pose T_R_F = forward(bench.scene.robot, q);
  const auto at = [&](double height) {
    return inverse(bench.scene.robot, Eigen::Translation3d(0, 0, height) * T_R_F, q).front().q;
  };
  PlanStep lift;
  lift.kind = Kind::kLift;
  lift.trajectory.time = {0.0, 1.0};
  lift.trajectory.q = {at(-0.02), at(0.05)};
  lift.trajectory.qd = {Joints::Zero(), Joints::Zero()};
  bench.plan.steps = {lift};
  std::vector<JointTrajectory> motions;
  bench.arm.after_motion = [&] { motions.push_back(bench.arm.followed); };
  (void)bench.run({});
  ASSERT_FALSE(motions.empty());
  EXPECT_LT((motions.front().q.front() - q).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((motions.front().q.back() - at(0.05)).cwiseAbs().maxCoeff(), 1e-4)
      << "where the next step begins";

  bench.plan.steps[0].trajectory.q.front() = q;  // as planned
  motions.clear();
  (void)bench.run({});
  ASSERT_FALSE(motions.empty());
  EXPECT_EQ(motions.front().q, bench.plan.steps[0].trajectory.q);
}

TEST(Execute, AFingerThatMeetsAStoneGoesBackAndPicksNothing) {
  Bench bench;
  PlanStep approach, grasp;
  approach.kind = Kind::kApproach;
  approach.threshold = 20.0;
  const Pose T_R_F = forward(bench.scene.robot, bench.arm.q);
  const Pose T_R_F_low = Eigen::Translation3d(0, 0, -0.03) * T_R_F;
  const Pose T_R_F_high = Eigen::Translation3d(0, 0, 0.07) * T_R_F;
  const auto at = [&](const Pose& T) { return inverse(bench.scene.robot, T, bench.arm.q).front().q; };
  approach.trajectory.time = {0.0, 1.0};
  approach.trajectory.q = {at(T_R_F_high), at(T_R_F_low)};  // the arm will stand 30 mm above the end
  approach.trajectory.qd = {Joints::Zero(), Joints::Zero()};
  grasp.kind = Kind::kGrasp;
  bench.plan.steps = {approach, grasp};
  const auto done = bench.run({Status::kContact});
  EXPECT_EQ(done.status, ExecutionResult::Status::kNotPicked);
  EXPECT_THAT(done.reason, testing::HasSubstr("30 mm above the grasp"));
  EXPECT_THAT(bench.arm.commands, testing::ElementsAre("lower", "follow")) << "the fingers do not close";
  const Pose T_back = forward(bench.scene.robot, bench.arm.followed.q.back());
  EXPECT_NEAR(difference(T_R_F, T_back).translation, 0.07, 0.001) << "back to where the approach began";
}

TEST(Execute, AnArmThatIsLostAtTheGraspIsNoFailedGrasp) {
  struct LostArm : scripted::ScriptedArm {  // and is there again
    void set_payload(double, const Eigen::Vector3d&) override {
      throw DeviceError("arm", "connection lost", "look at the cell");
    }
  };
  Bench bench;
  LostArm arm;
  PlanStep grasp;
  grasp.kind = Kind::kGrasp;
  bench.plan.steps = {grasp};
  bench.gripper.object = true;
  Cell cell{arm, bench.gripper, bench.force, bench.camera, *bench.clock, bench.layout};
  EXPECT_THROW((void)execute(bench.plan, bench.stone, bench.scene, cell, {}, nullptr), DeviceError);
  EXPECT_TRUE(arm.commands.empty()) << "no motion after the loss";
  EXPECT_THAT(bench.arm.commands, testing::ElementsAre("open")) << "closed once, not opened";
}

TEST(Execute, FingersAreSpacedBeforeTheGripperOpens) {
  Bench bench;
  PlanStep open;
  open.kind = Kind::kOpen;
  open.spacing = 0.042;
  bench.plan.steps = {open};
  (void)bench.run({});
  EXPECT_THAT(bench.arm.commands, testing::ElementsAre("spread", "open"));
  bench.plan.steps[0].spacing = 0.0;  // a plan of a gripper that has one spacing only
  (void)bench.run({});
  EXPECT_THAT(bench.arm.commands, testing::ElementsAre("open"));
}

TEST(Execute, AnEarlyTouchReleasesTheStoneThere) {
  Bench bench;
  const auto done = bench.run({Status::kContact});
  EXPECT_EQ(done.status, ExecutionResult::Status::kReleased);
  EXPECT_THAT(done.reason, testing::HasSubstr("early"));
  EXPECT_THAT(bench.arm.commands, testing::ElementsAre("follow", "lower", "open", "follow"));
}

TEST(Execute, AStoneThatNeverTouchesIsNotCarriedAround) {
  Bench bench;
  const auto done = bench.run({Status::kNoContact, Status::kNoContact});
  EXPECT_EQ(done.status, ExecutionResult::Status::kReleased);
  EXPECT_THAT(done.reason, testing::HasSubstr("no contact"));
  EXPECT_EQ(std::count(bench.arm.commands.begin(), bench.arm.commands.end(), "open"), 1);
}

TEST(Execute, AStoneThatTheWristDoesNotMeasureIsPutBack) {
  Bench bench;
  bench.plan.steps.resize(1);
  bench.plan.steps[0].kind = Kind::kLift;
  JointTrajectory& lift = bench.plan.steps[0].trajectory;
  lift.time = {0.0, 1.0};
  lift.q = {bench.arm.q, bench.arm.q};
  lift.qd = {Joints::Zero(), Joints::Zero()};
  bench.stone.mass.p_O_M = Eigen::Vector3d(0.01, 0.02, 0.03);
  const Eigen::Matrix3d R_W_F = (bench.layout.T_W_R * forward(bench.scene.robot, bench.arm.q)).linear();
  const auto hang = [&](double mass, const Eigen::Vector3d& p_F) {
    bench.force.wrench.force = R_W_F.transpose() * Eigen::Vector3d(0, 0, -9.81 * mass);
    bench.force.wrench.torque = p_F.cross(bench.force.wrench.force);
    return bench.run({Status::kContact});
  };
  const Eigen::Vector3d p_F = bench.layout.T_F_T * bench.stone.mass.p_O_M;  // T_O_T is the identity
  EXPECT_EQ(hang(1.0, p_F).status, ExecutionResult::Status::kReleased);
  EXPECT_EQ(bench.arm.guarded.size(), 1u) << "nothing to put back";
  const auto slipping = hang(0.4, p_F);
  EXPECT_EQ(slipping.status, ExecutionResult::Status::kNotPicked);
  EXPECT_THAT(slipping.reason, testing::HasSubstr("slipped"));
  EXPECT_THAT(bench.arm.commands, testing::ElementsAre("follow", "lower", "follow", "open", "follow"))
      << "a little up before the fingers open: they may stand on the table";
  EXPECT_EQ(hang(0.05, p_F).status, ExecutionResult::Status::kNotPicked);
  EXPECT_THAT(bench.arm.commands, testing::ElementsAre("follow", "open"))
      << "the stone lies below the gripper";
  // A stone that has turned pulls elsewhere; how far below does not matter.
  const auto turned = hang(1.0, p_F + R_W_F.transpose() * Eigen::Vector3d(0.03, 0, 0));
  EXPECT_EQ(turned.status, ExecutionResult::Status::kNotPicked);
  EXPECT_THAT(turned.reason, testing::HasSubstr("turned"));
  EXPECT_EQ(hang(1.0, p_F + R_W_F.transpose() * Eigen::Vector3d(0, 0, -0.03)).status,
            ExecutionResult::Status::kReleased);
  bench.gripper.object = true;  // a wrist that measures nothing is no reason to let go in the air
  EXPECT_EQ(hang(0.0, p_F).status, ExecutionResult::Status::kNotPicked);
  EXPECT_THAT(bench.arm.commands, testing::ElementsAre("follow", "lower", "follow", "open", "follow"));
}

TEST(Execute, RetreatsAsFarAsThePlanHasClearance) {
  Bench bench;
  const auto tool = [&](const Joints& q) { return Pose(forward(bench.scene.robot, q) * bench.scene.T_F_T); };
  const auto retreated = [&] {
    (void)bench.run({Status::kNoContact, Status::kContact});
    return (tool(bench.arm.followed.q.back()).translation() - tool(bench.arm.q).translation()).norm();
  };
  EXPECT_NEAR(retreated(), MotionOptions{}.approach, 1e-6) << "of a plan without a distance";
  const Pose T_R_F_back = tool(bench.arm.q) * Eigen::Translation3d(0, 0, -0.05) * bench.scene.T_F_T.inverse();
  JointTrajectory& planned = bench.plan.steps.back().trajectory;
  planned.time = {0.0, 1.0};
  planned.q = {bench.arm.q, inverse(bench.scene.robot, T_R_F_back, bench.arm.q).front().q};
  planned.qd = {Joints::Zero(), Joints::Zero()};
  EXPECT_NEAR(retreated(), 0.05, 1e-6);
}

TEST(Execute, RetreatsAsFarAsTheArmCanFollow) {
  Bench bench;
  // The tool points at the base, so that back is outwards, and the arm is nearly stretched.
  const Pose towards_base(Eigen::AngleAxisd(-M_PI_2, Eigen::Vector3d::UnitY()));
  constexpr double kStep = 0.001;
  std::vector<Joints> outwards;
  for (double x = 0.6;; x += kStep) {
    const Joints near = outwards.empty() ? home_joints() : outwards.back();
    const auto solutions =
        inverse(bench.scene.robot, Eigen::Translation3d(x, 0.15, 0.6) * towards_base, near);
    if (solutions.empty() || (!outwards.empty() && (solutions.front().q - near).norm() > 0.5)) break;
    outwards.push_back(solutions.front().q);
  }
  const auto before_end = [&](double distance) {
    return outwards[outwards.size() - 1 - static_cast<std::size_t>(std::lround(distance / kStep))];
  };
  const auto back_from = [&](double distance) {
    bench.arm.q = before_end(distance);
    const auto done = bench.run({Status::kNoContact, Status::kContact});
    EXPECT_EQ(done.status, ExecutionResult::Status::kReleased) << done.reason;
    return (forward(bench.scene.robot, bench.arm.followed.q.back()).translation() -
            forward(bench.scene.robot, bench.arm.q).translation())
        .norm();
  };
  const double approach = MotionOptions{}.approach;
  ASSERT_GT(outwards.size(), 2 * std::size_t(approach / kStep));
  EXPECT_NEAR(back_from(1.1 * approach), approach, 1e-6);
  EXPECT_NEAR(back_from(0.6 * approach), 0.5 * approach, 1e-6);
  bench.arm.q = before_end(0.1 * approach);
  EXPECT_EQ(bench.run({Status::kNoContact, Status::kContact}).status, ExecutionResult::Status::kStopped);
}

TEST(Execute, NearTheTableTheGripperRetreatsBeforeItOpensWide) {
  Bench bench;
  bench.plan.steps.insert(bench.plan.steps.begin() + 4, bench.plan.steps[3]);  // let go, then open wide
  bench.gripper.after_move = [&](double /*opening*/) { bench.gripper.object = false; };
  bench.gripper.object = true;
  static_cast<void>(bench.run({Status::kNoContact, Status::kContact}));
  const std::vector<std::string> high = bench.arm.commands;

  const auto down = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX());
  const Pose T_R_F = bench.layout.T_W_R.inverse() * Pose(Eigen::Translation3d(0.7, 0.2, 0.005) * down) *
                     bench.layout.T_F_T.inverse();
  const auto near = inverse(bench.scene.robot, T_R_F, home_joints());
  ASSERT_FALSE(near.empty());
  bench.arm.q = near.front().q;
  bench.gripper.object = true;
  static_cast<void>(bench.run({Status::kNoContact, Status::kContact}));
  const std::vector<std::string>& low = bench.arm.commands;
  ASSERT_EQ(low.size(), high.size() + 1) << "one more motion";
  const auto first_open = std::find(low.begin(), low.end(), "open");
  ASSERT_NE(first_open, low.end());
  EXPECT_EQ(*(first_open + 1), "follow");
  EXPECT_EQ(*(first_open + 2), "open");
}

TEST(Execute, NearTheTableFingersThatLostTheStoneRetreatBeforeTheyOpen) {
  Bench bench;
  const auto down = Eigen::AngleAxisd(M_PI - 0.3, Eigen::Vector3d::UnitY());
  const Pose T_R_F = bench.layout.T_W_R.inverse() * Pose(Eigen::Translation3d(0.7, 0.2, 0.02) * down) *
                     bench.layout.T_F_T.inverse();
  const auto near = inverse(bench.scene.robot, T_R_F, home_joints());
  ASSERT_FALSE(near.empty());
  bench.arm.q = near.front().q;
  bench.plan.steps[3].opening = 0.13;  // the lower finger would reach the table
  for (const bool holds : {true, false}) {
    bench.gripper.after_move = [&](double /*opening*/) { bench.gripper.object = false; };
    bench.gripper.object = holds;
    static_cast<void>(bench.run({Status::kNoContact, Status::kContact}));
    const std::vector<std::string>& done = bench.arm.commands;
    const auto open = std::find(done.begin(), done.end(), "open");
    ASSERT_NE(open, done.end());
    EXPECT_EQ(*(open - 1), holds ? "descend" : "follow") << "from a stone that is held nothing lifts it";
  }
}

TEST(Execute, AStopOfTheArmEndsIt) {
  Bench bench;
  const auto done = bench.run({Status::kStopped});
  EXPECT_EQ(done.status, ExecutionResult::Status::kStopped);
  EXPECT_THAT(bench.arm.commands, testing::ElementsAre("follow", "lower")) << "nothing moves after a stop";
}

}  // namespace
}  // namespace stonestack::stacking
