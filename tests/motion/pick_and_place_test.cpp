#include "stonestack/motion/pick_and_place.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "motion/constants.hpp"
#include "motion/grasp_check.hpp"
#include "motion/pick_and_place/pick_attempt.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

Stone block(const std::string& name, const Eigen::Vector3d& size, double density = 2600.0) {
  Stone stone;
  stone.name = name;
  stone.scan = stone.mesh = make_box(size);
  stone.pieces = {stone.scan};
  stone.mass = mass_properties(stone.scan, density);
  return stone;
}

/// A block in the field and a tower block at the site; the task sets the one on the other.
struct Workplace {
  Stone stone = block("block", {0.10, 0.08, 0.07});
  Stone tower = block("tower", {0.12, 0.12, 0.08});
  PlanningScene scene;
  PickAndPlaceTask task;

  Workplace() {
    scene.robot = read_robot("ur10");
    scene.T_F_T = Pose(Eigen::Translation3d(0, 0, 0.264));
    task.T_W_O_pick = Pose(Eigen::Translation3d(0.70, -0.18, 0.035));
    task.T_W_O_place = Pose(Eigen::Translation3d(0.70, 0.28, 0.08 + 0.035));
    scene.objects = {{"block", stone.pieces, task.T_W_O_pick},
                     {"tower", tower.pieces, Pose(Eigen::Translation3d(0.70, 0.28, 0.04))}};
    task.stone = &stone;
    task.object = 0;
    task.support = 1;
    task.q_start << 0.0, -1.8, 1.8, -1.57, -1.57, 0.0;
  }
};

Pose tool_at_end(const Workplace& cell, const PlanStep& step) {
  return cell.scene.T_W_R * forward(cell.scene.robot, step.trajectory.q.back()) * cell.scene.T_F_T;
}

/// A stone that lies against a wall would rub along it all the way up.
TEST(PickAndPlace, AStoneBesideAnotherIsMovedAwayFromItFirst) {
  Workplace cell;
  const double from_block = 0.04 + 0.0005 + 0.01;  // half a millimetre beside it
  cell.scene.objects.push_back(
      {"wall", {make_box({0.06, 0.02, 0.16})}, Pose(Eigen::Translation3d(0.70, -0.18 + from_block, 0.08))});
  const PickAndPlacePlan out = plan_pick_and_place(cell.scene, cell.task);
  ASSERT_EQ(out.status, PickAndPlacePlan::Status::kPlanned) << out.reason;
  const auto lift = std::find_if(out.steps.begin(), out.steps.end(),
                                 [](const PlanStep& step) { return step.kind == PlanStep::Kind::kLift; });
  ASSERT_NE(lift, out.steps.end());
  const Pose T_W_T_pick = cell.task.T_W_O_pick * out.T_O_T;
  double highest_beside_the_wall = 0.0;
  for (const Joints& q : lift->trajectory.q) {
    const Eigen::Vector3d moved =
        (cell.scene.T_W_R * forward(cell.scene.robot, q) * cell.scene.T_F_T).translation() -
        T_W_T_pick.translation();
    EXPECT_LT(moved.y(), 1e-4) << "never towards the wall";
    if (moved.y() > -0.005) highest_beside_the_wall = std::max(highest_beside_the_wall, moved.z());
  }
  EXPECT_LT(highest_beside_the_wall, 0.008);
  EXPECT_GT((tool_at_end(cell, *lift).translation() - T_W_T_pick.translation()).z(), 0.05);
}

TEST(PickAndPlace, PlansTheWholePath) {
  const Workplace cell;
  const PickAndPlacePlan plan = plan_pick_and_place(cell.scene, cell.task);
  ASSERT_EQ(plan.status, PickAndPlacePlan::Status::kPlanned) << plan.reason;
  Joints q = cell.task.q_start;
  for (const PlanStep& step : plan.steps) {
    if (step.trajectory.time.empty()) continue;
    // The retreat starts at the target, where the descent was expected to meet the support.
    if (step.kind != PlanStep::Kind::kRetreat) {
      EXPECT_LT((step.trajectory.q.front() - q).norm(), 1e-5) << step.name;
    }
    q = step.trajectory.q.back();
    if (step.kind == PlanStep::Kind::kDescent) {
      EXPECT_GE(step.threshold, 5.0);
      const Pose expected = cell.task.T_W_O_place * plan.T_O_T;
      const double past = expected.translation().z() - tool_at_end(cell, step).translation().z();
      EXPECT_GT(past, 0.0);
      EXPECT_LE(past, MotionOptions{}.descent_past + 1e-5);
      const double length = kDescentLength + past;
      EXPECT_GE(step.trajectory.duration(), length / MotionOptions{}.descent_speed - 1e-3);
    }
    if (step.name.rfind("approach", 0) == 0) {
      const Pose expected = cell.task.T_W_O_pick * plan.T_O_T;
      EXPECT_LT(difference(tool_at_end(cell, step), expected).translation, 1e-6);
    }
    if (step.kind == PlanStep::Kind::kGrasp) {
      EXPECT_GE(step.force, 15.0);
      EXPECT_LE(step.force, 60.0);
    }
  }
  EXPECT_LT(plan.seconds, 60.0);
}

/// Largest change of acceleration over 1 ms, rad/s^3, from the velocities alone.
double max_jerk(const JointTrajectory& t) {
  double max = 0.0;
  for (double at = 0.002; at < t.duration(); at += 0.001) {
    const Joints third = sample(t, at).qd - 2.0 * sample(t, at - 0.001).qd + sample(t, at - 0.002).qd;
    max = std::max(max, third.cwiseAbs().maxCoeff() / 1e-6);
  }
  return max;
}

TEST(PickAndPlace, KeepsTheJerkInEveryMotion) {
  const Workplace cell;
  MotionOptions smooth;
  smooth.jerk = 30.0;
  const PickAndPlacePlan fast = plan_pick_and_place(cell.scene, cell.task);
  const PickAndPlacePlan plan = plan_pick_and_place(cell.scene, cell.task, smooth);
  ASSERT_EQ(plan.status, PickAndPlacePlan::Status::kPlanned) << plan.reason;
  double without = 0.0;
  for (const PlanStep& step : fast.steps) without = std::max(without, max_jerk(step.trajectory));
  EXPECT_GT(without, 100.0) << "or there is nothing to limit";
  for (const PlanStep& step : plan.steps)
    EXPECT_LE(max_jerk(step.trajectory), 30.0 * (1 + 1e-6)) << step.name;
  EXPECT_GT(plan.seconds, fast.seconds);
}

TEST(PickAndPlace, SameSeedSamePlan) {
  const Workplace cell;
  const PickAndPlacePlan a = plan_pick_and_place(cell.scene, cell.task);
  const PickAndPlacePlan b = plan_pick_and_place(cell.scene, cell.task);
  ASSERT_EQ(a.steps.size(), b.steps.size());
  EXPECT_EQ(a.seconds, b.seconds);
  EXPECT_EQ(a.T_O_T.matrix(), b.T_O_T.matrix());
}

TEST(PickAndPlace, AGraspThatFailedOnceIsTakenAgainWhereThereIsNoOther) {
  Workplace cell;
  const auto plan = [&] { return plan_pick_and_place(cell.scene, cell.task); };
  const PickAndPlacePlan first = plan();
  ASSERT_EQ(first.status, PickAndPlacePlan::Status::kPlanned) << first.reason;
  cell.task.failed_once = {first.T_O_T};
  const PickAndPlacePlan second = plan();
  ASSERT_EQ(second.status, PickAndPlacePlan::Status::kPlanned) << second.reason;
  EXPECT_FALSE(is_near_grasp(cell.task.failed_once, second.T_O_T)) << "the block has another side";
  while (cell.task.avoid.size() < 100) {
    const PickAndPlacePlan next = plan();
    if (next.status != PickAndPlacePlan::Status::kPlanned || is_near_grasp(cell.task.failed_once, next.T_O_T))
      break;
    cell.task.avoid.push_back(next.T_O_T);
  }
  const PickAndPlacePlan last = plan();
  ASSERT_EQ(last.status, PickAndPlacePlan::Status::kPlanned) << last.reason;
  EXPECT_TRUE(is_near_grasp(cell.task.failed_once, last.T_O_T));
  cell.task.avoid.push_back(first.T_O_T);
  const PickAndPlacePlan none = plan();
  EXPECT_TRUE(none.status != PickAndPlacePlan::Status::kPlanned ||
              !is_near_grasp(cell.task.failed_once, none.T_O_T));
}

TEST(PickAndPlace, NamesTheObjectThatTheArmTouchesAtTheStart) {
  Workplace cell;
  const Eigen::Vector3d p_elbow =
      link_poses(cell.scene.robot, cell.task.q_start)[3].translation() + cell.scene.T_W_R.translation();
  cell.scene.objects.push_back({"scaffold", {make_box({0.1, 0.1, 0.1})}, make_pose(p_elbow)});
  const PickAndPlacePlan plan = plan_pick_and_place(cell.scene, cell.task);
  EXPECT_EQ(plan.status, PickAndPlacePlan::Status::kNoTransit);
  EXPECT_NE(plan.reason.find("at the start"), std::string::npos) << plan.reason;
  EXPECT_NE(plan.reason.find("scaffold"), std::string::npos) << plan.reason;
}

TEST(PickAndPlace, GivesTheReasonWhereThereIsNoPlan) {
  using Status = PickAndPlacePlan::Status;
  Workplace cell;
  cell.task.T_W_O_place.translation().x() = 2.5;
  PickAndPlacePlan plan = plan_pick_and_place(cell.scene, cell.task);
  EXPECT_NE(plan.status, Status::kPlanned);
  EXPECT_EQ(plan.status, Status::kNoReach);
  EXPECT_NE(plan.reason.find("the target of block is 2"), std::string::npos) << plan.reason;
  EXPECT_FALSE(can_grasp(cell.scene, cell.task));

  Workplace low;
  low.task.T_W_O_place.translation().z() = -0.10;
  plan = plan_pick_and_place(low.scene, low.task);
  EXPECT_NE(plan.status, Status::kPlanned);
  EXPECT_NE(plan.reason.find("135 mm into the table"), std::string::npos) << plan.reason;

  Workplace heavy;
  heavy.stone = block("lead", {0.10, 0.08, 0.07}, 11000.0);
  plan = plan_pick_and_place(heavy.scene, heavy.task);
  EXPECT_EQ(plan.status, Status::kTooHeavy);
  EXPECT_NE(plan.reason.find("kg"), std::string::npos) << plan.reason;

  Workplace weak;
  weak.scene.robot.payload = 4.5;  // the fingers could
  plan = plan_pick_and_place(weak.scene, weak.task);
  EXPECT_EQ(plan.status, Status::kTooHeavy);
  EXPECT_NE(plan.reason.find("kg; ur10 carries 4.5 kg, 3.35 kg of them the gripper"), std::string::npos)
      << plan.reason;

  Workplace wide;
  wide.stone = block("slab", {0.18, 0.18, 0.18}, 300.0);
  plan = plan_pick_and_place(wide.scene, wide.task);
  EXPECT_EQ(plan.status, Status::kTooWide) << plan.reason;
  EXPECT_NE(plan.reason.find("the gripper takes 0.02 to 0.143 m"), std::string::npos) << plan.reason;
  const GraspFinder finder(wide.scene, *wide.task.stone, wide.task.object, wide.task.T_W_O_pick);
  EXPECT_EQ(finder.at_pick().text(), "the fingers find no grasp on it, however it lies");
}

TEST(PickAndPlace, NamesAJointThatStartsOutsideItsLimits) {
  Workplace cell;
  cell.scene.robot.lower[4] = 0.5;
  const PickAndPlacePlan plan = plan_pick_and_place(cell.scene, cell.task);
  EXPECT_NE(plan.status, PickAndPlacePlan::Status::kPlanned);
  EXPECT_NE(plan.reason.find("wrist 2 at -1.57 rad, limits 0.5 to"), std::string::npos) << plan.reason;
}

TEST(PickAndPlace, LimitsNeedNotLieAboutZero) {
  Workplace cell;  // both ends are behind the half turn, at about -0.25 and 0.4 rad
  cell.scene.robot.lower[0] = 3.5;
  cell.scene.robot.upper[0] = 3.5 + 6.2;
  cell.task.q_start[0] = 6.2;
  const GraspCheck check = check_grasps(cell.scene, cell.task);
  EXPECT_FALSE(check.usable.empty()) << check.text();
  const PickAndPlacePlan plan = plan_pick_and_place(cell.scene, cell.task);
  ASSERT_EQ(plan.status, PickAndPlacePlan::Status::kPlanned) << plan.reason;
  for (const PlanStep& step : plan.steps)
    for (const Joints& q : step.trajectory.q) {
      EXPECT_GE(q[0], 3.5);
      EXPECT_LE(q[0], 3.5 + 6.2);
    }
}

TEST(PickAndPlace, NamesATargetInTheTable) {
  Workplace cell;
  cell.scene.objects.pop_back();
  cell.task.support = -1;
  cell.task.T_W_O_place.translation().z() = 0.035 - 0.030;
  const PickAndPlacePlan plan = plan_pick_and_place(cell.scene, cell.task);
  EXPECT_EQ(plan.status, PickAndPlacePlan::Status::kNoReach);
  EXPECT_EQ(plan.reason, "the target puts block 30 mm into the table");
  cell.task.T_W_O_place.translation().z() = 0.035 - 0.006;
  EXPECT_EQ(plan_pick_and_place(cell.scene, cell.task).reason, "the target puts block 6 mm into the table");
  cell.task.T_W_O_place.translation().z() = 0.035 - 0.002;  // what a measured pose may be off by
  EXPECT_EQ(plan_pick_and_place(cell.scene, cell.task).status, PickAndPlacePlan::Status::kPlanned);
}

TEST(PickAndPlace, NamesTheGraspsThatDoNotLiftTheStoneWhateverTheTarget) {
  // A board hangs over the tower that the stone stands on: gripper and wrist fit under it, but cannot go up.
  Workplace cell;
  std::swap(cell.task.T_W_O_pick, cell.task.T_W_O_place);
  cell.scene.objects[0].T_W_object = cell.task.T_W_O_pick;
  cell.task.support = -1;
  ASSERT_EQ(plan_pick_and_place(cell.scene, cell.task).status, PickAndPlacePlan::Status::kPlanned);
  cell.scene.objects.push_back(
      {"board", {make_box({0.4, 0.4, 0.02})}, Pose(Eigen::Translation3d(0.78, 0.28, 0.58))});
  const PickAndPlacePlan plan = plan_pick_and_place(cell.scene, cell.task);
  EXPECT_EQ(plan.status, PickAndPlacePlan::Status::kNoTransit) << plan.reason;
  EXPECT_GT(plan.no_pick.size(), 20U) << plan.reason;
  // In the opposite pose it can be picked up, by most of them.
  std::swap(cell.task.T_W_O_pick, cell.task.T_W_O_place);
  cell.scene.objects[0].T_W_object = cell.task.T_W_O_pick;
  const PickAndPlacePlan other = plan_pick_and_place(cell.scene, cell.task);
  EXPECT_EQ(other.status, PickAndPlacePlan::Status::kNoTransit) << other.reason;
  EXPECT_LT(other.no_pick.size(), 10U) << other.reason;
}

TEST(PickAndPlace, LiftsLessUnderAShelf) {
  Workplace cell;
  const Stone pedestal = block("pedestal", {0.05, 0.05, 0.40}), shelf = block("shelf", {0.5, 0.4, 0.02});
  cell.task.T_W_O_pick = cell.scene.objects[0].T_W_object = Pose(Eigen::Translation3d(0.75, -0.25, 0.435));
  cell.scene.objects.push_back({"pedestal", pedestal.pieces, Pose(Eigen::Translation3d(0.75, -0.25, 0.2))});
  cell.scene.objects.push_back({"shelf", shelf.pieces, Pose(Eigen::Translation3d(0.75, -0.25, 0.60))});
  const PickAndPlacePlan plan = plan_pick_and_place(cell.scene, cell.task);
  ASSERT_EQ(plan.status, PickAndPlacePlan::Status::kPlanned) << plan.reason;
}

TEST(PickAndPlace, ContactThresholdGrowsWithTheStone) {
  const MotionOptions options;
  EXPECT_DOUBLE_EQ(contact_threshold(0.3, options), options.min_threshold);
  EXPECT_NEAR(contact_threshold(2.5, options), kThresholdShare * 2.5 * 9.81, 1e-12);
  MotionOptions noisy;
  noisy.force_noise = 2.0;
  EXPECT_DOUBLE_EQ(contact_threshold(0.3, noisy), 12.0);
  EXPECT_THROW((void)contact_threshold(0.0), InvalidArgument);
  Workplace cell;  // and the plan reports it
  cell.stone = block("block", {0.10, 0.08, 0.07}, 3500.0);
  const PickAndPlacePlan plan = plan_pick_and_place(cell.scene, cell.task);
  ASSERT_EQ(plan.status, PickAndPlacePlan::Status::kPlanned) << plan.reason;
  for (const PlanStep& step : plan.steps)
    if (step.kind == PlanStep::Kind::kDescent) {
      EXPECT_DOUBLE_EQ(step.threshold, contact_threshold(cell.stone.mass.mass));
      EXPECT_GT(step.threshold, options.min_threshold);
    }
}

TEST(PickAndPlace, RefusesTasksThatCannotBe) {
  Workplace cell;
  cell.task.T_W_O_place.translation().x() = std::nan("");
  EXPECT_THROW((void)plan_pick_and_place(cell.scene, cell.task), InvalidArgument);
  Workplace index;
  index.task.object = 7;
  EXPECT_THROW((void)plan_pick_and_place(index.scene, index.task), InvalidArgument);
  Workplace none;
  none.task.stone = nullptr;
  EXPECT_THROW((void)plan_pick_and_place(none.scene, none.task), InvalidArgument);
}

TEST(GraspFinder, WallAroundTheStoneLeavesNoGrasp) {
  Workplace cell;
  EXPECT_TRUE(can_grasp(cell.scene, cell.task));
  const Mesh wall = make_box({0.30, 0.02, 0.30});
  for (const double y : {-0.08, 0.08})
    cell.scene.objects.push_back({"wall", {wall}, Pose(Eigen::Translation3d(0.70, -0.18 + y, 0.15))});
  const Mesh end = make_box({0.02, 0.30, 0.30});
  for (const double x : {-0.09, 0.09})
    cell.scene.objects.push_back({"wall", {end}, Pose(Eigen::Translation3d(0.70 + x, -0.18, 0.15))});
  const GraspCheck check = check_grasps(cell.scene, cell.task);
  EXPECT_TRUE(check.usable.empty());
  int refused = 0;
  for (const int count : check.refused) refused += count;
  EXPECT_EQ(refused, check.total);
  EXPECT_NE(check.text().find("hit another object at pick"), std::string::npos) << check.text();
}

TEST(GraspFinder, OpenFingersMayMeetTheForearmWhereClosedOnesDoNot) {
  const Workplace cell;
  const GraspFinder finder(cell.scene, *cell.task.stone, cell.task.object, cell.task.T_W_O_pick);
  const std::vector<Grasp>& grasps = finder.set().grasps;
  const auto wider = [](const Grasp& a, const Grasp& b) { return a.pre_opening < b.pre_opening; };
  const auto widest = std::max_element(grasps.begin(), grasps.end(), wider);
  PlanningScene alone = cell.scene;
  alone.objects.clear();
  alone.gripper = with_spacing(alone.gripper, widest->spacing);
  CollisionRules closed, open;
  closed.opening = 0.0;
  open.opening = widest->pre_opening;
  const CollisionChecker without(alone, closed), with(alone, open);
  Random random(7);
  int met = 0;
  while (met < 5) {
    Joints q;
    for (int j = 0; j < 6; ++j) q[j] = random.uniform(-3.0, 3.0);
    if (without.collides(q) || !with.collides(q)) continue;
    const Clearance nearest = with.clearance(q);
    if (nearest.first == "table" || nearest.second == "table") continue;
    ++met;
    EXPECT_FALSE(finder.arm_is_free(static_cast<int>(widest - grasps.begin()), q))
        << nearest.first << ' ' << nearest.second << ' ' << q.transpose();
  }
}

TEST(GraspFinder, AtAGraspTheArmMayComeAsNearToTheTableAsOnAnApproach) {
  Workplace cell;
  cell.scene.objects.resize(1);  // the stone itself does not count
  const GraspFinder finder(cell.scene, *cell.task.stone, cell.task.object, cell.task.T_W_O_pick);
  const Grasp& grasp = finder.set().grasps.front();
  PlanningScene alone = cell.scene;
  alone.objects.clear();
  alone.gripper = with_spacing(alone.gripper, grasp.spacing);
  CollisionRules near, far;
  near.padding = MotionOptions{}.approach_padding;
  near.opening = far.opening = alone.gripper.max_opening;
  far.gripper_may_touch = {kTableObject};
  const CollisionChecker approach(alone, near), transit(alone, far);
  Random random(11);
  int between = 0;
  while (between < 3) {
    Joints q;
    for (int j = 0; j < 6; ++j) q[j] = random.uniform(-3.0, 3.0);
    if (approach.collides(q) || !transit.collides(q)) continue;
    ++between;
    EXPECT_TRUE(finder.arm_is_free(0, q)) << q.transpose();
  }
}

TEST(GraspFinder, StonesThatWillStandByThenAreAvoided) {
  const Workplace cell;
  const GraspFinder finder(cell.scene, *cell.task.stone, cell.task.object, cell.task.T_W_O_pick);
  const Pose& T_W_O = cell.task.T_W_O_place;
  const GraspCheck alone = finder.check(T_W_O);
  ASSERT_FALSE(alone.usable.empty());
  // Two walls that only leave space for the stone itself.
  std::vector<SceneObject> walls;
  for (const double side : {-1.0, 1.0}) {
    const Pose T_W_wall = Eigen::Translation3d(0.0, side * 0.09, 0.0) * T_W_O;
    walls.push_back(
        {"wall", {make_box({0.5, 0.02, 0.4})}, Pose(Eigen::Translation3d(T_W_wall.translation()))});
    walls.push_back({"wall",
                     {make_box({0.02, 0.5, 0.4})},
                     Pose(Eigen::Translation3d(T_W_O.translation() + Eigen::Vector3d(side * 0.09, 0, 0)))});
  }
  const GraspCheck later = finder.check(T_W_O, 0, walls);
  EXPECT_TRUE(later.usable.empty());
  EXPECT_GT(later.refused[static_cast<std::size_t>(GraspFault::kObjectAtPlace)], 0);
  EXPECT_EQ(finder.check(T_W_O).usable, alone.usable) << "the finder itself has not changed";
  // The same walls far from the target do no harm, although the arm passes there.
  for (SceneObject& wall : walls) wall.T_W_object.pretranslate(Eigen::Vector3d(0, 3, 0));
  EXPECT_EQ(finder.check(T_W_O, 0, walls).usable, alone.usable);
}

TEST(PickAndPlace, RetreatsFromWhereTheArmIs) {
  const Workplace cell;
  const PickAndPlacePlan plan = plan_pick_and_place(cell.scene, cell.task);
  ASSERT_EQ(plan.status, PickAndPlacePlan::Status::kPlanned);
  const Joints q = plan.steps.back().trajectory.q.front();
  const auto retreat = plan_retreat(cell.scene, q, plan.steps.front().opening, 0);
  ASSERT_TRUE(retreat.has_value());
  EXPECT_LT((retreat->q.front() - q).norm(), 1e-9);
  const Pose from = forward(cell.scene.robot, q), to = forward(cell.scene.robot, retreat->q.back());
  EXPECT_NEAR((from.inverse() * to).translation().z(), -MotionOptions{}.approach, 1e-6);
}

}  // namespace
}  // namespace stonestack::motion
