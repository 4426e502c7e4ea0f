#include "stacking/stepped_devices.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scripted_cell.hpp"
#include "stacking/record.hpp"
#include "temporary_folder.hpp"

namespace stonestack::scripted {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// The base joint turns by 0.5 rad in two seconds.
JointTrajectory turn() {
  JointTrajectory move;
  move.time = {0.0, 1.0, 2.0};
  move.q = {home_joints(), home_joints(), home_joints()};
  move.q[1][0] += 0.25;
  move.q[2][0] += 0.5;
  move.qd = {Joints::Zero(), Joints::Zero(), Joints::Zero()};
  move.qd[1][0] = 0.375;
  return move;
}

class SteppedDevices : public testing::Test {
 protected:
  Bench bench_;
  std::vector<std::string> asked_;
  std::size_t allowed_ = 100;
  const stacking::BeforeMotion ask_ = [this](const stacking::PlannedStep& notice) {
    asked_.push_back(to_text(notice));
    return asked_.size() <= allowed_;
  };
  std::string path_ = test::temporary_folder() + "stepped.jsonl";
};

TEST_F(SteppedDevices, AskBeforeEachMotionAndNothingElse) {
  stacking::Journal journal;
  stacking::SteppedDevices devices(bench_.cell, bench_.scene.robot, ask_, &journal);
  Cell cell = devices.cell();
  (void)cell.arm.state();
  cell.arm.set_payload(2.0, Eigen::Vector3d::Zero());
  EXPECT_TRUE(asked_.empty());
  (void)cell.arm.follow(turn());
  cell.gripper.move(0.04, 0.06, 40.0);
  cell.gripper.spread(0.042);
  bench_.arm.guarded = {Status::kContact};
  GuardedMotion descent;
  descent.trajectory = turn();
  (void)cell.arm.follow_guarded(descent);
  cell.gripper.move(0.155, 0.06, 40.0);
  cell.gripper.move(0.0, 0.06, 40.0);
  ASSERT_EQ(asked_.size(), 6U);
  EXPECT_THAT(asked_[0], testing::MatchesRegex("move the arm: 2.0 s, tool up to 0\\.[23][0-9]+ m/s"));
  EXPECT_EQ(asked_[1], "close the fingers to 40 mm");
  EXPECT_EQ(asked_[2], "bring fingers B and C to a distance of 42 mm");
  EXPECT_EQ(asked_[4], "open the fingers to 155 mm");
  EXPECT_EQ(asked_[5], "close the fingers on the stone, with 40 N");
  EXPECT_THAT(bench_.arm.commands, ElementsAre("follow", "open", "spread", "descend", "open", "open"));
}

TEST_F(SteppedDevices, MoveNothingOnceTheAnswerIsNo) {
  stacking::SteppedDevices devices(bench_.cell, bench_.scene.robot, ask_, nullptr);
  Cell cell = devices.cell();
  allowed_ = 0;
  EXPECT_THROW((void)cell.arm.follow(turn()), Interrupted);
  EXPECT_THROW((void)cell.arm.follow_guarded({turn()}), Interrupted);
  EXPECT_THROW(cell.gripper.move(0.04, 0.06, 40.0), Interrupted);
  EXPECT_THROW(cell.gripper.spread(0.042), Interrupted);
  EXPECT_TRUE(bench_.arm.commands.empty());
  cell.arm.stop();
  EXPECT_THAT(bench_.arm.commands, ElementsAre("stop")) << "a stop asks nobody";
}

TEST_F(SteppedDevices, KnowTheStepThatTheJournalHas) {
  stacking::Journal journal(path_);
  stacking::SteppedDevices devices(bench_.cell, bench_.scene.robot, ask_, &journal);
  Cell cell = devices.cell();
  record(&journal, StepBegun{"move above limestone_3"});
  (void)cell.arm.follow(turn());
  EXPECT_THAT(asked_.back(), HasSubstr("move above limestone_3: 2.0 s"));
}

// A person says no in the middle of a plan: what comes later is not done.
TEST_F(SteppedDevices, EndAPlanBetweenItsSteps) {
  stacking::SteppedDevices devices(bench_.cell, bench_.scene.robot, ask_, nullptr);
  Cell cell = devices.cell();
  for (auto& step : bench_.plan.steps) step.trajectory = turn();
  allowed_ = 1;
  EXPECT_THROW((void)execute(bench_.plan, bench_.stone, bench_.scene, cell, {}, nullptr), Interrupted);
  EXPECT_THAT(bench_.arm.commands, ElementsAre("follow"));
}

}  // namespace
}  // namespace stonestack::scripted
