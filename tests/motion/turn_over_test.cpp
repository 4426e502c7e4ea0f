#include "motion/turn_over.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

/// 10 x 8 x 5 cm, lying on its largest side.
Stone brick() {
  Stone stone;
  stone.name = "brick";
  stone.scan = stone.mesh = make_box({0.10, 0.08, 0.05});
  stone.pieces = {stone.scan};
  stone.mass = mass_properties(stone.scan, 2600.0);
  return stone;
}

Eigen::Quaterniond about_x(double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()));
}

double tilt_of(const Eigen::Quaterniond& R_W_O) {
  return std::acos(std::clamp((R_W_O * Eigen::Vector3d::UnitZ()).z(), -1.0, 1.0));
}

TEST(TippedOver, ALittleTiltFallsBack) {
  EXPECT_LT(tilt_of(tipped_over(brick(), about_x(0.3))), 0.06);
}

TEST(TippedOver, BeyondItsEdgeItFallsOnTheNextSide) {
  // Its middle is above the edge at atan(80 / 50) = 1.01 rad.
  EXPECT_LT(tilt_of(tipped_over(brick(), about_x(0.93))), 0.06);
  EXPECT_NEAR(tilt_of(tipped_over(brick(), about_x(1.1))), 0.5 * M_PI, 0.06);
}

TEST(WaysToTurn, EachBringsAnotherSideUp) {
  const Stone stone = brick();
  const auto ways = ways_to_turn(stone, Eigen::Quaterniond::Identity());
  ASSERT_FALSE(ways.empty());
  bool sets_down = false, lets_fall = false;
  for (const TurnTo& way : ways) {
    EXPECT_GT(tilt_of(way.R_W_O_rest), 1.4);
    const bool stays = way.R_W_O.angularDistance(way.R_W_O_rest) < 0.1;
    (stays ? sets_down : lets_fall) = true;
    if (!stays) {
      EXPECT_GT(way.apart, RegraspOptions{}.apart) << "what falls over needs room";
      EXPECT_LT(tilt_of(way.R_W_O), 1.5) << "it is turned less than until it lies on its side";
    }
  }
  EXPECT_TRUE(sets_down);
  EXPECT_TRUE(lets_fall);
}

/// The brick alone in the field of a UR10.
struct Field {
  Stone stone = brick();
  PlanningScene scene;
  PickAndPlaceTask task;

  Field() {
    scene.robot = read_robot("ur10");
    scene.T_F_T = Pose(Eigen::Translation3d(0, 0, 0.264));
    task.T_W_O_pick = make_pose({0.70, -0.18, 0.025});
    scene.objects = {{stone.name, stone.pieces, task.T_W_O_pick}};
    task.stone = &stone;
    task.object = 0;
    task.q_start << 0.0, -1.8, 1.8, -1.57, -1.57, 0.0;
  }
};

TEST(PlanTurn, SetsTheStoneDownOnAnotherSide) {
  const Field field;
  const auto ways = ways_to_turn(field.stone, Eigen::Quaterniond::Identity());
  const auto plan = plan_turn(field.scene, field.task, ways);
  ASSERT_TRUE(plan.has_value());
  EXPECT_EQ(plan->plan.status, PickAndPlacePlan::Status::kPlanned);
  EXPECT_GT(tilt_of(Eigen::Quaterniond(plan->T_W_O.linear())), 1.4);
  double lowest = 1.0;
  for (const auto& v : field.stone.scan.vertices) lowest = std::min(lowest, (plan->T_W_O * v).z());
  EXPECT_NEAR(lowest, 0.0, 1e-6) << "it lies on the table";
}

TEST(PlanTurn, NoWayGivesNoPlan) {
  const Field field;
  EXPECT_FALSE(plan_turn(field.scene, field.task, {}).has_value());
  PickAndPlaceTask none = field.task;
  none.stone = nullptr;
  EXPECT_THROW((void)plan_turn(field.scene, none, {}), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::motion
