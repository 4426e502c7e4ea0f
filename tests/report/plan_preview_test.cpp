#include "stonestack/report/plan_preview.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::report {
namespace {

using Kind = PlanStep::Kind;

/// A block in the field goes onto a tower block at the site.
class PlanPreview : public testing::Test {
 protected:
  static Stone block(const std::string& name, const Eigen::Vector3d& size) {
    Stone stone;
    stone.name = name;
    stone.scan = stone.mesh = make_box(size);
    stone.pieces = {stone.scan};
    stone.mass = mass_properties(stone.scan, 2600.0);
    return stone;
  }
  void SetUp() override {
    scene.robot = read_robot("ur10");
    scene.T_F_T = Pose(Eigen::Translation3d(0, 0, 0.264));
    task.T_W_O_pick = Pose(Eigen::Translation3d(0.70, -0.18, 0.035));
    task.T_W_O_place = Pose(Eigen::Translation3d(0.70, 0.28, 0.115));
    scene.objects = {{"block", stone.pieces, task.T_W_O_pick},
                     {"tower", tower.pieces, Pose(Eigen::Translation3d(0.70, 0.28, 0.04))}};
    task.stone = &stone;
    task.object = 0;
    task.support = 1;
    task.q_start << 0.0, -1.8, 1.8, -1.57, -1.57, 0.0;
    plan = plan_pick_and_place(scene, task);
    ASSERT_EQ(plan.status, PickAndPlacePlan::Status::kPlanned) << plan.reason;
    moments = preview(scene, task, plan, 0.05);
  }
  /// Where the moved stone is drawn: its mesh comes last.
  [[nodiscard]] Pose drawn_stone(const PlanMoment& moment) const {
    return drawn_moment(scene, task, plan, moment).back().T_W_A;
  }

  Stone stone = block("block", {0.10, 0.08, 0.07});
  Stone tower = block("tower", {0.12, 0.12, 0.08});
  PlanningScene scene;
  PickAndPlaceTask task;
  PickAndPlacePlan plan;
  std::vector<PlanMoment> moments;
};

TEST_F(PlanPreview, TimeRisesAndStepsFollowEachOther) {
  EXPECT_EQ(moments.front().q, task.q_start);
  for (std::size_t i = 1; i < moments.size(); ++i) {
    EXPECT_GE(moments[i].time, moments[i - 1].time);
    EXPECT_GE(moments[i].step, moments[i - 1].step);
    EXPECT_LT((moments[i].q - moments[i - 1].q).norm(), 0.35) << "no jump, not even where the descent ends";
  }
}

TEST_F(PlanPreview, ToolSpeedIsTheDifferenceOfPositions) {
  double worst = 0.0, fastest = 0.0;
  for (std::size_t i = 1; i + 1 < moments.size(); ++i) {
    const auto &a = moments[i - 1], &b = moments[i + 1];
    if (a.step != b.step || b.time - a.time < 0.099) continue;
    const auto at = [&](const PlanMoment& m) {
      return (forward(scene.robot, m.q) * scene.T_F_T).translation().eval();
    };
    worst = std::max(worst, std::abs((at(b) - at(a)).norm() / (b.time - a.time) - moments[i].tool_speed));
    fastest = std::max(fastest, moments[i].tool_speed);
  }
  EXPECT_GT(fastest, 0.2);
  EXPECT_LT(worst, 0.05 * fastest);
}

TEST_F(PlanPreview, ClearanceKeepsThePaddingInTransit) {
  const MotionOptions options;
  for (const auto& m : moments) {
    EXPECT_GT(m.clearance, -1e-6) << plan.steps[m.step].name;
    if (plan.steps[m.step].kind == Kind::kTransit) {
      EXPECT_GT(m.clearance, options.approach_padding) << m.time;
    }
    EXPECT_LT(m.clearance, 0.5);
  }
}

TEST_F(PlanPreview, ClearanceShrinksWithAWallBesideThePath) {
  double before = 1.0, after = 1.0;
  for (const auto& m : moments) before = std::min(before, m.clearance);
  scene.objects.push_back({"wall", {make_box({0.3, 0.02, 1.0})}, Pose(Eigen::Translation3d(0.7, 0.05, 0.5))});
  for (const auto& m : preview(scene, task, plan, 0.05)) after = std::min(after, m.clearance);
  EXPECT_GT(before, -1e-6);
  EXPECT_LT(after, 0.0) << "the plan was made without the wall";
}

TEST_F(PlanPreview, KeyMomentsShowTheStoneWhereItIs) {
  const auto keys = key_moments(moments);
  std::size_t motions = 0;
  for (const auto& step : plan.steps) motions += step.trajectory.time.empty() ? 0 : 1;
  ASSERT_EQ(keys.size(), motions + 1);
  EXPECT_LT(difference(drawn_stone(keys.front()), task.T_W_O_pick).translation, 1e-9);
  EXPECT_LT(difference(drawn_stone(keys.back()), task.T_W_O_place).translation, 1e-9);
  for (const auto& key : keys) {
    if (plan.steps[key.step].kind != Kind::kDescent) continue;
    EXPECT_LT(difference(drawn_stone(key), task.T_W_O_place).translation, 1e-4);
  }
}

TEST_F(PlanPreview, PlotHasEveryCurveAndStep) {
  const std::string svg = plan_plot(plan, moments);
  for (const char* name : {"wrist 3", "tool speed, mm/s", "clearance, mm", "s of motion", "lift block"})
    EXPECT_THAT(svg, testing::HasSubstr(name));
  std::size_t paths = 0;
  for (std::size_t at = svg.find("<path"); at != std::string::npos; at = svg.find("<path", at + 1)) ++paths;
  EXPECT_EQ(paths, 8u) << "six joints, speed, clearance";
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

TEST_F(PlanPreview, RefusesWhatIsNoPlan) {
  EXPECT_THROW((void)preview(scene, task, plan, 0.0), InvalidArgument);
  plan.status = PickAndPlacePlan::Status::kNoGrasp;
  EXPECT_THROW((void)preview(scene, task, plan, 0.05), InvalidArgument);
  EXPECT_THROW((void)plan_plot(plan, {}), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::report
