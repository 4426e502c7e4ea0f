#include "motion/transit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "kinematics/inverse.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

using hardware::CellLayout;

Joints transit_tool_down() {
  Joints q;
  q << 0, -0.5 * kPi, 0.5 * kPi, -0.5 * kPi, -0.5 * kPi, 0;
  return q;
}

SceneObject transit_box_at(const std::string& name, const Eigen::Vector3d& size, const Eigen::Vector3d& p) {
  return {name, {make_box(size)}, make_pose(p)};
}

PlanningScene empty_transit_scene() {
  PlanningScene scene;
  scene.robot = read_robot("ur10");
  scene.T_F_T = CellLayout().T_F_T;
  return scene;
}

/// A wall between the two places, a post beside it and a bar above the wall: the gripper has to go around or
/// through the gap.
PlanningScene hard_scene() {
  PlanningScene scene = empty_transit_scene();
  scene.objects = {transit_box_at("wall", {0.5, 0.05, 0.35}, {0.75, 0.0, 0.175}),
                   transit_box_at("bar", {1.0, 0.05, 0.05}, {0.75, 0.0, 0.95}),
                   transit_box_at("tower", {0.12, 0.12, 0.4}, {0.5, 0.65, 0.2}),
                   transit_box_at("post", {0.05, 0.05, 1.0}, {0.45, -0.6, 0.5})};
  return scene;
}

std::vector<Joints> solutions_above(const PlanningScene& scene, const Eigen::Vector3d& p_W_tip) {
  Pose T_W_T = Pose::Identity();
  T_W_T.linear() = Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()).toRotationMatrix();
  T_W_T.translation() = p_W_tip;
  std::vector<Joints> goals;
  for (const auto& s : inverse(scene.robot, T_W_T * scene.T_F_T.inverse(), transit_tool_down()))
    goals.push_back(s.q);
  EXPECT_FALSE(goals.empty());
  return goals;
}

void expect_free(const CollisionChecker& checker, const JointPath& path) {
  for (std::size_t i = 1; i < path.size(); ++i) {
    const int steps = static_cast<int>((path[i] - path[i - 1]).cwiseAbs().maxCoeff() / 0.0005) + 1;
    for (int k = 0; k <= steps; ++k)
      ASSERT_FALSE(checker.collides(path[i - 1] + (path[i] - path[i - 1]) * k / steps));
  }
}

TEST(Transit, StaysInTheWorkspaceOfTheCell) {
  PlanningScene scene = empty_transit_scene();
  scene.objects = {transit_box_at("wall", {1.4, 0.05, 0.45}, {0.95, 0.0, 0.225})};
  const auto highest = [&](const JointPath& path) {
    double z = -1.0;
    for (std::size_t i = 1; i < path.size(); ++i)
      for (int k = 0; k <= 200; ++k) {
        const Joints q = path[i - 1] + (path[i] - path[i - 1]) * k / 200.0;
        z = std::max(z, (forward(scene.robot, q) * scene.T_F_T).translation().z());
      }
    return z;
  };
  const auto find = [&] {
    const auto goals = solutions_above(scene, {0.7, 0.3, 0.3});
    return find_path(CollisionChecker(scene), solutions_above(scene, {0.7, -0.3, 0.3}).front(), goals);
  };
  const auto free = find();
  ASSERT_TRUE(free);
  const double over = highest(*free);
  ASSERT_GT(over, 0.45) << "the wall obstructs the path";
  scene.robot.workspace = ToolWorkspace{
      {Eigen::Vector3d(-2, -2, 0), Eigen::Vector3d(2, 2, over + 0.05)}, scene.T_W_R, scene.T_F_T};
  const auto low = find();
  ASSERT_TRUE(low);
  EXPECT_LT(highest(*low), over + 0.05);
  scene.robot.workspace->box.max().z() = 0.40;
  scene.robot.workspace->box.min().x() = 0.3;  // nor behind the robot's back
  EXPECT_FALSE(find()) << "over the wall, and no other path";
}

TEST(Transit, GoesStraightWhereNothingObstructs) {
  const PlanningScene scene = empty_transit_scene();
  const CollisionChecker checker(scene);
  const Joints start = solutions_above(scene, {0.7, -0.3, 0.3}).front();
  const auto goals = solutions_above(scene, {0.7, 0.3, 0.3});
  const auto path = find_path(checker, start, goals);
  ASSERT_TRUE(path.has_value());
  EXPECT_EQ(path->size(), 2u);
  EXPECT_EQ(path->front(), start);
  EXPECT_NE(std::find(goals.begin(), goals.end(), path->back()), goals.end());
}

TEST(Transit, GoesAroundObstaclesAndIsFreeAtTenTimesTheResolution) {
  const PlanningScene scene = hard_scene();
  const CollisionChecker checker(scene);
  Random random = Random::stream(1, "transit");
  int bent = 0;
  for (int k = 0; k < 8; ++k) {
    const Joints start =
        solutions_above(scene, {random.uniform(0.6, 0.9), random.uniform(-0.4, -0.25), 0.15}).front();
    const auto goals = solutions_above(scene, {random.uniform(0.75, 0.9), random.uniform(0.25, 0.4), 0.15});
    if (checker.collides(start)) continue;
    const auto path = find_path(checker, start, goals);
    ASSERT_TRUE(path.has_value()) << "problem " << k;
    EXPECT_NE(std::find(goals.begin(), goals.end(), path->back()), goals.end());
    expect_free(checker, *path);
    bent += path->size() > 2 ? 1 : 0;
  }
  EXPECT_GT(bent, 3) << "the scene must obstruct the path";
}

TEST(Transit, SameSeedSamePath) {
  const PlanningScene scene = hard_scene();
  const CollisionChecker checker(scene);
  const Joints start = solutions_above(scene, {0.8, -0.3, 0.15}).front();
  const auto goals = solutions_above(scene, {0.8, 0.3, 0.15});
  MotionOptions options;
  const auto first = find_path(checker, start, goals, options);
  const auto second = find_path(checker, start, goals, options);
  options.seed = 2;
  const auto other = find_path(checker, start, goals, options);
  ASSERT_TRUE(first && second && other);
  EXPECT_EQ(*first, *second);
  EXPECT_NE(*first, *other);
}

TEST(Transit, GivesUpWhereThereIsNoPath) {
  PlanningScene scene = empty_transit_scene();
  const Joints start = transit_tool_down();
  EXPECT_TRUE(find_path(CollisionChecker(scene), start, solutions_above(scene, {0.8, 0.3, 0.3})).has_value());
  // A goal in a closed cage.
  for (const double side : {-1.0, 1.0}) {
    scene.objects.push_back(transit_box_at("x", {0.02, 0.8, 1.6}, {0.8 + side * 0.35, 0.3, 0.8}));
    scene.objects.push_back(transit_box_at("y", {0.7, 0.02, 1.6}, {0.8, 0.3 + side * 0.4, 0.8}));
  }
  MotionOptions options;
  options.planning_effort = 0.05;
  EXPECT_FALSE(find_path(CollisionChecker(scene), start, solutions_above(scene, {0.8, 0.3, 0.3}), options)
                   .has_value());
  EXPECT_FALSE(find_path(CollisionChecker(scene), start, {}, options).has_value()) << "no goal at all";
  EXPECT_THROW((void)find_path(CollisionChecker(scene), Joints::Constant(std::nan("")), {}), InvalidArgument);
}

TEST(Transit, StopsWhenItsEffortIsSpent) {
  const PlanningScene scene = hard_scene();
  const CollisionChecker checker(scene);
  MotionOptions little;
  little.planning_effort = 1e-4;
  int hasty = 0;
  for (int k = 0; k < 6; ++k) {
    const double x = 0.7 + 0.04 * k;
    const Joints start = solutions_above(scene, {x, -0.3, 0.15}).front();
    const std::vector<Joints> goal{solutions_above(scene, {x, 0.3, 0.15}).front()};
    EXPECT_TRUE(find_path(checker, start, goal).has_value()) << "at x " << x;
    hasty += find_path(checker, start, goal, little).has_value() ? 1 : 0;
  }
  EXPECT_LT(hasty, 6);
}

TEST(Transit, GivesUpEarlyWhereNothingWasFound) {
  const PlanningScene scene = hard_scene();
  const CollisionChecker checker(scene);
  int hasty = 0;
  for (int k = 0; k < 6; ++k) {
    const double x = 0.7 + 0.04 * k;
    const Joints start = solutions_above(scene, {x, -0.3, 0.15}).front();
    const std::vector<Joints> goal{solutions_above(scene, {x, 0.3, 0.15}).front()};
    hasty += find_path(checker, start, goal, {}, 1e-4).has_value() ? 1 : 0;
    EXPECT_EQ(find_path(checker, start, goal, {}, 1.0), find_path(checker, start, goal))
        << "found in time: the same path";
  }
  EXPECT_LT(hasty, 6);
}

/// A goal one hundredth of a millimetre outside the padding is reached all the same.
TEST(Transit, ReachesAGoalThatNearlyCollides) {
  PlanningScene scene = hard_scene();
  const Joints start = solutions_above(scene, {0.8, -0.3, 0.15}).front();
  const Joints goal = solutions_above(scene, {0.8, 0.3, 0.15}).front();
  scene.objects.push_back(transit_box_at("near", {0.3, 0.02, 0.3}, {0.8, 0.43, 0.15}));
  CollisionRules rules;
  rules.self_padding = 0.0;
  double free = 0.0, hit = 0.1;
  while (hit - free > 1e-7) {
    rules.padding = 0.5 * (free + hit);
    (CollisionChecker(scene, rules).collides(goal) ? hit : free) = rules.padding;
  }
  rules.padding = free - 1e-5;
  const CollisionChecker checker(scene, rules);
  ASSERT_FALSE(checker.collides(goal));
  const auto path = find_path(checker, start, std::vector<Joints>{goal});
  ASSERT_TRUE(path.has_value());
  expect_free(checker, *path);
}

/// Fingers that let go beside another stone are no further open than there was clearance.
TEST(Transit, LeavesWithTheGripperAsFarOpenAsItIs) {
  PlanningScene scene = empty_transit_scene();
  const Joints start = transit_tool_down();
  const Pose T_W_T = scene.T_W_R * forward(scene.robot, start) * scene.T_F_T;
  for (const double side : {-1.0, 1.0}) {  // a wall close to either finger, 60 mm from the middle
    const Eigen::Vector3d p = T_W_T * Eigen::Vector3d(side * (0.060 + 0.013 + 0.01), 0, -0.02);
    scene.objects.push_back({"wall", {make_box({0.02, 0.02, 0.02})}, make_pose(p)});
  }
  const Pose up = Pose(Eigen::Translation3d(0, 0, 0.2)) * scene.T_W_R * forward(scene.robot, start);
  EXPECT_FALSE(plan_transit(scene, start, up)) << "opened to 155 mm it would stand in the walls";
  scene.opening = 0.090;
  EXPECT_TRUE(plan_transit(scene, start, up));
}

TEST(Transit, IsTimedFromStartToGoal) {
  const PlanningScene scene = hard_scene();
  const Joints start = solutions_above(scene, {0.8, -0.3, 0.15}).front();
  Pose T_W_F = forward(scene.robot, solutions_above(scene, {0.8, 0.3, 0.15}).front());
  const auto trajectory = plan_transit(scene, start, T_W_F);
  ASSERT_TRUE(trajectory.has_value());
  EXPECT_EQ(sample(*trajectory, 0.0).q, start);
  const Pose reached = forward(scene.robot, trajectory->q.back());
  EXPECT_TRUE(reached.isApprox(T_W_F, 1e-9));
  EXPECT_TRUE(trajectory->qd.back().isZero(1e-9));
  // Corners are rounded within the padding: nothing is touched in between.
  CollisionRules bare;
  bare.padding = bare.self_padding = 0.0;
  const CollisionChecker checker(scene, bare);
  for (double t = 0.0; t < trajectory->duration(); t += 0.002)
    ASSERT_FALSE(checker.collides(sample(*trajectory, t).q));
}

TEST(Transit, ToWhereTheArmIsTakesNoTime) {
  const PlanningScene scene = empty_transit_scene();
  const auto trajectory = plan_transit(scene, transit_tool_down(), transit_tool_down());
  ASSERT_TRUE(trajectory.has_value());
  EXPECT_DOUBLE_EQ(trajectory->duration(), 0.0);
}

}  // namespace
}  // namespace stonestack::motion
