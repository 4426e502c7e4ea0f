#include "motion/push.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "motion/collision.hpp"
#include "motion/regrasp.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack::motion {
namespace {

using Kind = PlanStep::Kind;

/// A stone on the table, to be pushed towards +x.
struct PushBench {
  Catalogue catalogue = read_catalogue(data_path("stones"));
  const Stone& stone = catalogue.stones[1];
  PlanningScene scene;
  PushTask task;

  PushBench() {
    scene.robot = read_robot("ur10");
    scene.T_F_T = hardware::CellLayout().T_F_T;
    task.stone = &stone;
    task.object = 0;
    task.T_W_O = make_pose(Eigen::Vector3d::Zero(), rest_poses(stone).front().R_W_O);
    double low = 1.0;
    for (const auto& p : stone.scan.vertices) low = std::min(low, (task.T_W_O * p).z());
    task.T_W_O.translation() << 0.65, -0.15, -low;
    task.p_W_shift << 0.05, 0.0;
    task.q_start << 0, -1.5708, 1.5708, -1.5708, -1.5708, 0;
    scene.objects.push_back({stone.name, stone.pieces, task.T_W_O});
  }
  /// Ends of the stone along x, W [m].
  [[nodiscard]] std::pair<double, double> ends() const {
    double low = 10.0, high = -10.0;
    for (const auto& p : stone.scan.vertices) {
      low = std::min(low, (task.T_W_O * p).x());
      high = std::max(high, (task.T_W_O * p).x());
    }
    return {low, high};
  }
  void add_wall(double x) {
    const Eigen::Vector3d p_W(x, task.T_W_O.translation().y(), 0.1);
    scene.objects.push_back({"wall", {make_box({0.02, 0.5, 0.2})}, make_pose(p_W)});
  }
  [[nodiscard]] Eigen::Vector3d tip(const Joints& q) const {
    return (scene.T_W_R * forward(scene.robot, q) * scene.T_F_T).translation();
  }
};

TEST(PlanPush, TheClosedGripperPushesThroughTheCentreOfMass) {
  const PushBench bench;
  const PickAndPlacePlan plan = plan_push(bench.scene, bench.task);
  ASSERT_EQ(plan.status, PickAndPlacePlan::Status::kPlanned) << plan.reason;
  ASSERT_EQ(plan.steps.size(), 8U);
  EXPECT_EQ(plan.steps.front().kind, Kind::kOpen);
  EXPECT_EQ(plan.steps.front().opening, 0.0) << "closed before it goes there";
  EXPECT_EQ(plan.steps.back().opening, bench.scene.gripper.max_opening);
  const PlanStep &up_to_it = plan.steps[3], &push = plan.steps[4];
  ASSERT_EQ(up_to_it.kind, Kind::kDescent);
  ASSERT_EQ(push.kind, Kind::kDescent);
  const Eigen::Vector3d start = bench.tip(up_to_it.trajectory.q.front());
  const Eigen::Vector3d from = bench.tip(push.trajectory.q.front());
  const Eigen::Vector3d to = bench.tip(push.trajectory.q.back());
  EXPECT_NEAR(start.y(), (bench.task.T_W_O * bench.stone.mass.p_O_M).y(), 1e-3);
  EXPECT_LT((to - start).normalized().cross(Eigen::Vector3d::UnitX()).norm(), 1e-3);
  EXPECT_LT(start.x(), bench.ends().first) << "it begins behind the stone";
  EXPECT_NEAR((from - start).x(), 0.025, 1e-3) << "the stone may lie further away than it was seen";
  EXPECT_GT(bench.ends().first - start.x(), 0.028) << "half a closed gripper and 8 mm";
  EXPECT_NEAR((to - from).x(), bench.task.p_W_shift.x(), 1e-3);
  EXPECT_LT(up_to_it.threshold, 0.5 * 9.81 * bench.stone.mass.mass) << "the stone is felt when it slides";
  EXPECT_GT(push.threshold, 0.5 * 9.81 * bench.stone.mass.mass) << "more than the stone's friction";
  for (std::size_t k = 1; k < plan.steps.size(); ++k) {
    const JointPath& q = plan.steps[k].trajectory.q;
    const JointPath& before = plan.steps[k - 1].trajectory.q;
    if (q.empty() || before.empty()) continue;
    EXPECT_LT((q.front() - before.back()).norm(), 0.01) << plan.steps[k].name;
  }
}

TEST(PlanPush, MeetsNothingButTheStone) {
  PushBench bench;
  bench.scene.objects.push_back({"post",
                                 {make_box({0.03, 0.03, 0.12})},
                                 make_pose(Eigen::Vector3d(bench.ends().first - 0.02, -0.05, 0.06))});
  const PickAndPlacePlan plan = plan_push(bench.scene, bench.task);
  ASSERT_EQ(plan.status, PickAndPlacePlan::Status::kPlanned) << plan.reason;
  CollisionRules rules;
  rules.padding = 0.001;
  rules.opening = 0.0;
  rules.left_out = 0;
  const CollisionChecker checker(bench.scene, rules);
  for (const PlanStep& step : plan.steps)
    for (const Joints& q : step.trajectory.q) EXPECT_FALSE(checker.collides(q)) << step.name;
}

TEST(PlanPush, NeedsRoomBehindTheStone) {
  PushBench bench;
  bench.add_wall(bench.ends().first - 0.015);
  const PickAndPlacePlan plan = plan_push(bench.scene, bench.task);
  EXPECT_EQ(plan.status, PickAndPlacePlan::Status::kNoTransit);
  EXPECT_THAT(plan.reason, testing::HasSubstr(bench.stone.name));
  PushBench open;
  open.add_wall(open.ends().first - 0.30);
  EXPECT_EQ(plan_push(open.scene, open.task).status, PickAndPlacePlan::Status::kPlanned);
}

// Blocks on both sides of the way keep the gripper from going down near the stone with all the clearance that
// it would like to have; a push that begins behind them must not end before the stone moves.
TEST(PlanPush, BringsTheStoneAsFarAsAskedWhereverItBegins) {
  for (const double aside : {0.042, 0.044, 0.046}) {
    PushBench bench;
    bench.task.p_W_shift << 0.03, 0.0;
    const double y = (bench.task.T_W_O * bench.stone.mass.p_O_M).y(), x = bench.ends().first - 0.025;
    for (const double side : {-1.0, 1.0})
      bench.scene.objects.push_back({"block",
                                     {make_box({0.04, 0.04, 0.06})},
                                     make_pose(Eigen::Vector3d(x, y + side * (aside + 0.02), 0.03))});
    const PickAndPlacePlan plan = plan_push(bench.scene, bench.task);
    ASSERT_EQ(plan.status, PickAndPlacePlan::Status::kPlanned) << plan.reason;
    const auto push = std::find_if(plan.steps.begin(), plan.steps.end(),
                                   [](const PlanStep& step) { return step.name.starts_with("push "); });
    ASSERT_NE(push, plan.steps.end());
    const Eigen::Vector3d to = bench.tip(push->trajectory.q.back());
    // The closed fingers are 40 mm deep and 73 mm wide.
    EXPECT_GT(to.x() + 0.0365, bench.ends().first + bench.task.p_W_shift.x()) << aside;
  }
}

TEST(PlanPush, RefusesTasksThatCannotBe) {
  PushBench bench;
  bench.task.p_W_shift.setZero();
  EXPECT_THROW((void)plan_push(bench.scene, bench.task), InvalidArgument);
  bench.task.p_W_shift << 0.05, std::nan("");
  EXPECT_THROW((void)plan_push(bench.scene, bench.task), InvalidArgument);
  bench.task.p_W_shift << 0.05, 0.0;
  bench.task.stone = nullptr;
  EXPECT_THROW((void)plan_push(bench.scene, bench.task), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::motion
