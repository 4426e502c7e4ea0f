#include "motion/turn_over.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

/// Lies on its largest side.
Stone brick(const Eigen::Vector3d& size = {0.10, 0.08, 0.05}) {
  Stone stone;
  stone.name = "brick";
  stone.scan = stone.mesh = make_box(size);
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

// Its middle is above the edge at 1.19 rad.
TEST(WaysToTurn, AFlatStoneFallsOverWhereItIsTurnedFurther) {
  const Stone stone = brick({0.14, 0.10, 0.04});
  int fall = 0;
  for (const TurnTo& way : ways_to_turn(stone, Eigen::Quaterniond::Identity()))
    if (way.R_W_O.angularDistance(way.R_W_O_rest) > 0.1) {
      ++fall;
      EXPECT_FALSE(way.certain);
      EXPECT_GT(tilt_of(way.R_W_O), 1.19 + 0.1) << "it would fall back";
      EXPECT_GT(tilt_of(way.R_W_O_rest), 1.4);
    }
  EXPECT_GT(fall, 2);
}

/// The brick alone in the field of a UR10.
struct Field {
  Stone stone;
  PlanningScene scene;
  PickAndPlaceTask task;

  explicit Field(const Eigen::Vector3d& size = {0.10, 0.08, 0.05}) : stone(brick(size)) {
    scene.robot = read_robot("ur10");
    scene.T_F_T = Pose(Eigen::Translation3d(0, 0, 0.264));
    task.T_W_O_pick = make_pose({0.70, -0.18, 0.5 * size.z()});
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

/// Height above the table of the lowest point of the stone at the end of a plan's descent [m].
double height_after_descent(const Field& field, const TurnPlan& turn) {
  const auto descent = std::find_if(turn.plan.steps.begin(), turn.plan.steps.end(), [](const PlanStep& step) {
    return step.kind == PlanStep::Kind::kDescent;
  });
  if (descent == turn.plan.steps.end()) return NAN;
  const Pose T_W_T = forward(field.scene.robot, descent->trajectory.q.back()) * field.scene.T_F_T;
  const Pose T_W_O = T_W_T * turn.plan.T_O_T.inverse();
  double lowest = 1.0;
  for (const auto& v : field.stone.scan.vertices) lowest = std::min(lowest, (T_W_O * v).z());
  return lowest;
}

TEST(PlanTurn, WhereTheGripperMeetsTheTableTheStoneIsLetGoOfAboveIt) {
  const Field field({0.14, 0.10, 0.04});
  int above = 0, on_it = 0;
  for (int k = 0; k < 24 && (above == 0 || on_it == 0); ++k) {
    const double axis = 2.0 * M_PI * k / 24;
    const Eigen::Quaterniond let_go(
        Eigen::AngleAxisd(1.58, Eigen::Vector3d(std::cos(axis), std::sin(axis), 0.0)));
    const TurnTo way{let_go, tipped_over(field.stone, let_go), 0.05};
    const auto plan = plan_turn(field.scene, field.task, {&way, 1});
    if (!plan) continue;
    SCOPED_TRACE(concat("axis at ", axis, " rad, let go of at ", plan->height, " m"));
    EXPECT_LT(plan->height, 0.021);
    const double lowest = height_after_descent(field, *plan);
    if (plan->height > 0) {
      EXPECT_LT(lowest, plan->height + 1e-3);
      EXPECT_GT(lowest, plan->height - 0.003) << "the gripper would meet the table";
      ++above;
    } else {
      EXPECT_LT(lowest, 1e-3);
      ++on_it;
    }
  }
  EXPECT_GT(above, 0);
  EXPECT_GT(on_it, 0);
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
