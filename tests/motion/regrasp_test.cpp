#include "motion/regrasp.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "motion/grasp_check.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

using Status = PickAndPlacePlan::Status;

Stone regrasp_block(const std::string& name, const Eigen::Vector3d& size) {
  Stone stone;
  stone.name = name;
  stone.scan = stone.mesh = make_box(size);
  stone.pieces = {stone.scan};
  stone.mass = mass_properties(stone.scan, 2600.0);
  return stone;
}

/// A block lies in the field; the target wants it upside down, which no grasp from above brings about.
struct RegraspWorkplace {
  Stone stone = regrasp_block("block", {0.10, 0.08, 0.07});
  PlanningScene scene;
  PickAndPlaceTask task;

  RegraspWorkplace() {
    scene.robot = read_robot("ur10");
    scene.T_F_T = Pose(Eigen::Translation3d(0, 0, 0.264));
    task.T_W_O_pick = make_pose({0.70, -0.18, 0.035});
    task.T_W_O_place = make_pose({0.70, 0.28, 0.035}, Eigen::Quaterniond(0, 1, 0, 0));
    scene.objects = {{"block", stone.pieces, task.T_W_O_pick}};
    task.stone = &stone;
    task.object = 0;
    task.q_start << 0.0, -1.8, 1.8, -1.57, -1.57, 0.0;
  }
};

double lowest(const Stone& stone, const Pose& T_W_O) {
  double z = 1.0;
  for (const auto& v : stone.scan.vertices) z = std::min(z, (T_W_O * v).z());
  return z;
}

TEST(RestPoses, ABoxRestsOnItsSixFaces) {
  const Stone stone = regrasp_block("block", {0.10, 0.08, 0.07});
  const auto rests = rest_poses(stone);
  ASSERT_EQ(rests.size(), 6u);
  for (const auto& rest : rests) {
    const Eigen::Vector3d up = rest.R_W_O.inverse() * Eigen::Vector3d::UnitZ();
    EXPECT_NEAR(up.cwiseAbs().maxCoeff(), 1.0, 1e-9) << "an axis of the box is upright";
  }
  // The largest margin comes first: the two faces of 0.10 x 0.08.
  EXPECT_NEAR(std::abs((rests[0].R_W_O.inverse() * Eigen::Vector3d::UnitZ()).z()), 1.0, 1e-9);
}

TEST(RestPoses, ASlabDoesNotStandOnItsEdge) {
  EXPECT_EQ(rest_poses(regrasp_block("slab", {0.10, 0.10, 0.006})).size(), 2u);
  EXPECT_THROW((void)rest_poses(Stone{}), InvalidArgument);
}

/// The angle counts, not the margin alone: the same 10 mm hold a low block and not a tall one.
TEST(RestPoses, ATallStoneDoesNotStandOnItsEnd) {
  EXPECT_EQ(rest_poses(regrasp_block("low", {0.02, 0.02, 0.02})).size(), 6u);
  const Stone tall = regrasp_block("pillar", {0.02, 0.02, 0.16});
  EXPECT_EQ(rest_poses(tall).size(), 4u);
  RegraspOptions careless;
  careless.rest_tilt = 0.0;
  const auto rests = rest_poses(tall, careless);
  ASSERT_EQ(rests.size(), 6u);
  for (const auto& rest : rests) {
    const bool on_end = std::abs((rest.R_W_O.inverse() * Eigen::Vector3d::UnitZ()).z()) > 0.9;
    EXPECT_NEAR(rest.margin, 0.01, 1e-9);
    EXPECT_NEAR(rest.tilt, std::atan2(0.01, on_end ? 0.08 : 0.01), 1e-9);
  }
}

TEST(RestPoses, LeavesOutWhatDidNotHold) {
  const Stone stone = regrasp_block("block", {0.10, 0.08, 0.07});
  RegraspOptions options;
  options.n_O_not_up = {Eigen::Vector3d(0.1, 0, 1).normalized()};  // 6 deg beside a face
  const auto rests = rest_poses(stone, options);
  EXPECT_EQ(rests.size(), 5U);
  for (const RestPose& rest : rests) EXPECT_LT((rest.R_W_O.inverse() * Eigen::Vector3d::UnitZ()).z(), 0.5);
}

TEST(GraspFinder, SamplesMoreWhereHardlyAnyGraspServes) {
  // A wall stands on either side of the block, so that one of its two widths is out of the question.
  RegraspWorkplace cell;
  const int usual = GraspFinder(cell.scene, cell.stone, 0, cell.task.T_W_O_pick).set().tried;
  const Mesh wall = make_box({0.02, 0.30, 0.10});
  cell.scene.objects.push_back({"wall", {wall}, make_pose({0.70 + 0.066, -0.18, 0.05})});
  cell.scene.objects.push_back({"wall", {wall}, make_pose({0.70 - 0.066, -0.18, 0.05})});
  cell.scene.objects.push_back(
      {"wall", {make_box({0.11, 0.02, 0.10})}, make_pose({0.70, -0.18 + 0.08, 0.05})});
  const GraspFinder walled(cell.scene, cell.stone, 0, cell.task.T_W_O_pick);
  EXPECT_GT(walled.set().tried, 3 * usual);
}

/// A loaf 28 mm high with slanting sides: what holds it comes from above, and the usual directions hardly
/// meet it.
Stone loaf() {
  Stone stone = regrasp_block("loaf", {0.15, 0.10, 0.028});
  for (auto* mesh : {&stone.scan, &stone.mesh, &stone.pieces[0]})
    for (Eigen::Vector3d& v : mesh->vertices)
      if (v.z() > 0.0) v.head<2>() *= 0.97;
  stone.mass = mass_properties(stone.scan, 2600.0);
  return stone;
}

TEST(GraspFinder, SamplesDenselyFromAboveWhereTheTableObstructs) {
  const Stone stone = loaf();
  RegraspWorkplace cell;
  const Pose T_W_O = make_pose({0.70, -0.18, 0.014});
  cell.scene.objects = {{"loaf", stone.pieces, T_W_O}};
  const auto usual = cached_grasps(stone, cell.scene.gripper);
  const GraspFinder finder(cell.scene, stone, 0, T_W_O);
  std::size_t of_usual = 0;
  for (const int k : finder.at_pick().usable) {
    const Grasp& grasp = finder.set().grasps[static_cast<std::size_t>(k)];
    for (const Grasp& other : usual->grasps) of_usual += other.T_O_T.matrix() == grasp.T_O_T.matrix() ? 1 : 0;
    EXPECT_LT((T_W_O * grasp.T_O_T).linear()(2, 2), -0.5) << "from above";
  }
  EXPECT_LT(of_usual, 12U);
  EXPECT_GT(finder.at_pick().usable.size(), 3 * of_usual);
  EXPECT_TRUE(finder.at_pick().can_be_held());
}

TEST(GraspFinder, AStoneThatNoFingerReachesUnderCannotBeHeld) {
  const Stone plate = regrasp_block("plate", {0.12, 0.10, 0.008});
  RegraspWorkplace cell;
  const Pose T_W_O = make_pose({0.70, -0.18, 0.004});
  cell.scene.objects = {{"plate", plate.pieces, T_W_O}};
  EXPECT_FALSE(GraspFinder(cell.scene, plate, 0, T_W_O).at_pick().can_be_held());
  // Walls around a stone are no fault of the stone.
  cell.scene.objects = {{"block", cell.stone.pieces, cell.task.T_W_O_pick},
                        {"lid", {make_box({0.3, 0.3, 0.02})}, make_pose({0.70, -0.18, 0.12})}};
  const GraspFinder lidded(cell.scene, cell.stone, 0, cell.task.T_W_O_pick);
  EXPECT_TRUE(lidded.at_pick().usable.empty());
  EXPECT_TRUE(lidded.at_pick().can_be_held());
}

TEST(RegraspFinder, ReportsTheResultOfAReorientation) {
  const RegraspWorkplace cell;
  const auto finder = [&](std::span<const Pose> avoid = {}) {
    return RegraspFinder(cell.scene, cell.stone, cell.task.object, cell.task.T_W_O_pick, avoid);
  };
  const RegraspFinder turning = finder();
  EXPECT_TRUE(turning.serves(cell.task.T_W_O_place)) << "TurnsAStoneOver does it";
  Pose far = cell.task.T_W_O_place;
  far.translation().x() += 2.0;
  EXPECT_FALSE(turning.serves(far));
  // A wall stands around the target by then.
  std::vector<SceneObject> walls;
  for (const double side : {-0.12, 0.12})
    walls.push_back(
        {"wall",
         {make_box({0.3, 0.1, 0.8})},
         Pose(Eigen::Translation3d(0, side, 0.37)) * make_pose(cell.task.T_W_O_place.translation())});
  for (const double side : {-0.12, 0.12})
    walls.push_back(
        {"wall",
         {make_box({0.1, 0.3, 0.8})},
         Pose(Eigen::Translation3d(side, 0, 0.37)) * make_pose(cell.task.T_W_O_place.translation())});
  EXPECT_FALSE(turning.serves(cell.task.T_W_O_place, walls));

  std::vector<Pose> all;
  for (const Grasp& grasp : cached_grasps(cell.stone, cell.scene.gripper)->grasps) all.push_back(grasp.T_O_T);
  EXPECT_FALSE(finder(all).serves(cell.task.T_W_O_place)) << "it cannot be picked up at all";
  EXPECT_THROW(static_cast<void>(turning.serves(Pose(Eigen::Scaling(2.0)))), InvalidArgument);
}

TEST(Regrasp, TurnsAStoneOver) {
  const RegraspWorkplace cell;
  ASSERT_FALSE(can_grasp(cell.scene, cell.task)) << "or this test tries nothing";
  const RegraspPlan plan = plan_regrasp(cell.scene, cell.task);
  ASSERT_TRUE(plan.planned) << plan.reason;
  EXPECT_EQ(plan.plans.front().status, Status::kPlanned);
  EXPECT_EQ(plan.plans.back().status, Status::kPlanned);
  EXPECT_NEAR(lowest(cell.stone, plan.T_W_O_between.front()), 0.0, 1e-9) << "it stands on the table";
  ASSERT_EQ(plan.tilts.size(), plan.T_W_O_between.size());
  EXPECT_GE(plan.tilts.front(), RegraspOptions{}.rest_tilt);

  // The second half starts where the first ends, and takes the stone where the first put it.
  const Joints end = plan.plans.front().steps.back().trajectory.q.back();
  bool moved = false, grasped = false;
  Joints before = end;
  for (const auto& step : plan.plans.back().steps) {
    if (step.kind == PlanStep::Kind::kGrasp) {
      const Pose T_W_T = forward(cell.scene.robot, before) * cell.scene.T_F_T;
      const Pose T_W_O = T_W_T * plan.plans.back().T_O_T.inverse();
      EXPECT_LT(difference(T_W_O, plan.T_W_O_between.front()).translation, 1e-5);
      EXPECT_LT(difference(T_W_O, plan.T_W_O_between.front()).angle, 1e-4);
      grasped = true;
    }
    if (step.trajectory.time.empty()) continue;
    if (!moved) {
      EXPECT_LT((step.trajectory.q.front() - end).norm(), 1e-9);
    }
    moved = true;
    before = step.trajectory.q.back();
  }
  EXPECT_TRUE(grasped);
}

TEST(Regrasp, GivesTheReasonWhereItCannotHelp) {
  RegraspWorkplace cell;
  cell.task.T_W_O_place.translation().x() = 2.5;
  const RegraspPlan plan = plan_regrasp(cell.scene, cell.task);
  EXPECT_FALSE(plan.planned);
  EXPECT_NE(plan.reason.find("0 at the target"), std::string::npos) << plan.reason;
}

TEST(Regrasp, KeepsAwayFromOtherStones) {
  RegraspWorkplace cell;
  const Mesh rock = make_box({0.06, 0.06, 0.06});
  cell.scene.objects.push_back({"rock", {rock}, make_pose({0.70, -0.05, 0.03})});
  const RegraspPlan plan = plan_regrasp(cell.scene, cell.task);
  ASSERT_TRUE(plan.planned) << plan.reason;
  for (const auto& v : cell.stone.scan.vertices) {
    const Eigen::Vector3d p = plan.T_W_O_between.front() * v - Eigen::Vector3d(0.70, -0.05, 0.03);
    EXPECT_GT(p.cwiseAbs().maxCoeff(), 0.03);
  }
}

}  // namespace
}  // namespace stonestack::motion
