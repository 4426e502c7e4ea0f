#include "motion/grasp/finger_reach.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kinematics/inverse.hpp"
#include "motion/collision.hpp"
#include "motion/grasp.hpp"
#include "motion/grasp_check.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

const GripperModel kFlatJaws = make_robotiq_3f(), kThreeFingers = make_robotiq_3f(Linkage::kThreeFinger);

/// Half opening and height of the tip over the palm's joint [m] with that joint at `theta`, pad upright:
/// joint origins and limits of robotiq-3f-gripper_finger_articulated_macro.xacro (ros-industrial), the last
/// phalanx of 38.1 mm and its plate of 7.9 mm from the meshes, rubber of 3.2 mm on it.
Eigen::Vector2d published_tip(double theta) {
  const Eigen::Rotation2Dd first(theta), second(theta - 0.52);
  const Eigen::Vector2d joint = first * Eigen::Vector2d(0.050, -0.028) + second * Eigen::Vector2d(0.039, 0.0);
  return {0.0455 - joint.y() - 0.0079 - 0.0032, joint.x() + 0.0381};
}
constexpr double kOpenAngle = 0.0495;  // rad

TEST(FingerReach, FollowsThePublishedPhalangesToAMillimetre) {
  const Eigen::Vector2d open = published_tip(kOpenAngle);
  EXPECT_NEAR(2.0 * open.x(), kThreeFingers.max_opening, 0.0005) << "of the data sheet";
  double highest = 0.0, at_highest = 0.0;
  for (double theta = kOpenAngle; published_tip(theta).x() >= 0.0; theta += 0.005) {
    const Eigen::Vector2d tip = published_tip(theta);
    const double opening = 2.0 * tip.x(), advance = tip.y() - open.y();
    EXPECT_NEAR(tip_advance(kThreeFingers, opening), advance, 0.001) << opening;
    if (advance > highest) {
      highest = advance;
      at_highest = opening;
    }
  }
  EXPECT_NEAR(highest, 0.0102, 0.0002) << "the fingers are longest half closed";
  EXPECT_NEAR(at_highest, 0.069, 0.002);
  EXPECT_NEAR(tip_advance(kThreeFingers, 0.155), 0.0, 1e-9);
  EXPECT_NEAR(tip_advance(kThreeFingers, 0.2), 0.0, 1e-9);
  EXPECT_NEAR(tip_advance(kThreeFingers, -0.01), tip_advance(kThreeFingers, 0.0), 1e-9);
}

TEST(FingerReach, FlatJawsStayAtOneHeight) {
  for (const double opening : {0.0, 0.05, 0.155}) EXPECT_EQ(tip_advance(kFlatJaws, opening), 0.0);
  EXPECT_EQ(furthest_tip(kFlatJaws, 0.02, 0.155), 0.0);
  EXPECT_EQ(linkage_named("parallel"), Linkage::kParallel);
  EXPECT_EQ(linkage_named("three_finger"), Linkage::kThreeFinger);
  EXPECT_THROW((void)linkage_named("scissor"), InvalidArgument);
}

TEST(FingerReach, TheFurthestTipIsOnTheWayNotAtAnEnd) {
  const double ends = std::max(tip_advance(kThreeFingers, 0.02), tip_advance(kThreeFingers, 0.155));
  EXPECT_GT(furthest_tip(kThreeFingers, 0.155, 0.02), ends + 0.002);
  EXPECT_EQ(furthest_tip(kThreeFingers, 0.155, 0.02), furthest_tip(kThreeFingers, 0.02, 0.155));
  EXPECT_NEAR(furthest_tip(kThreeFingers, 0.155, 0.13), tip_advance(kThreeFingers, 0.13), 1e-12);
}

/// The parts near the palm hardly move, since the fingers turn there.
TEST(FingerReach, FingersLeanAndTheirTipsAdvance) {
  for (const double opening : {0.0, 0.05, 0.1, 0.155}) {
    double tip = -1.0, pad = 1.0, base = 0.0;
    for (const GripperBox& box : kThreeFingers.boxes) {
      if (box.finger_side <= 0.0) continue;
      const Eigen::Vector3d p = box_centre(kThreeFingers, box, opening);
      const double front = p.z() + 0.5 * box.size.z(), inside = p.x() - 0.5 * box.size.x();
      if (front > tip) {
        tip = front;
        pad = inside;
      }
      if (p.z() < -0.09) base = p.x();
    }
    EXPECT_NEAR(tip, tip_advance(kThreeFingers, opening), 1e-12);
    EXPECT_NEAR(pad, 0.5 * opening, 1e-12);
    EXPECT_GT(base, 0.035) << "beside the palm's joint, 45.5 mm from the middle";
    EXPECT_LT(base, 0.075) << "the same";
  }
}

Stone reach_block() {
  Stone stone;
  stone.name = "block";
  stone.scan = stone.mesh = make_box({0.12, 0.09, 0.06});
  stone.pieces = {stone.scan};
  stone.mass = mass_properties(stone.scan, 2600.0);
  return stone;
}

/// Contacts lie on the pads, which stand where the tips do.
TEST(FingerReach, GraspsHaveTheirContactsOnTheAdvancedPads) {
  GraspOptions few;
  few.directions = 60;
  const GraspSet set = grasp_candidates(reach_block(), kThreeFingers, few);
  ASSERT_GT(set.grasps.size(), 20u);
  for (const Grasp& grasp : set.grasps) {
    const double tip = tip_advance(kThreeFingers, grasp.opening);
    ASSERT_EQ(grasp.contacts, 3);
    for (std::size_t i = 0; i < 3; ++i) {
      const double z = (grasp.T_O_T.inverse() * grasp.p_O_contact[i]).z();
      EXPECT_LE(z, tip + 1e-9);
      EXPECT_GE(z, tip - kThreeFingers.pad_length - 1e-9);
    }
  }
}

/// Fingers lean inwards to the palm when they are far open: a tall wide stone must fit between them there.
TEST(FingerReach, TallStonesStayClearOfTheLeaningFingers) {
  EXPECT_NEAR(finger_inside(kThreeFingers, 0.12, 0.0), 0.06, 1e-12) << "the pad's face";
  EXPECT_NEAR(finger_inside(kThreeFingers, 0.12, -kPalmJoint), 0.0405, 1e-12) << "at the palm's joint";
  EXPECT_EQ(finger_inside(kFlatJaws, 0.12, -0.1), 0.06);
  Stone stone = reach_block();
  stone.scan = stone.mesh = make_box({0.10, 0.10, 0.10});
  stone.pieces = {stone.scan};
  stone.mass = mass_properties(stone.scan, 1000.0);
  GraspOptions few;
  few.directions = 60;
  const auto surface = sample_surface(stone.scan, 0.004);
  const auto min_gap = [&](const Grasp& grasp) {
    const Pose T_T_O = grasp.T_O_T.inverse();
    double min = 1.0;
    for (const SurfaceSample& sample : surface) {
      const Eigen::Vector3d p = T_T_O * sample.point;
      if (p.z() > tip_advance(kThreeFingers, grasp.opening) - kThreeFingers.pad_length) continue;
      const double middle = p.x() > 0 ? 0.0 : 0.5 * grasp.spacing;
      if (std::abs(std::abs(p.y()) - middle) < 0.5 * kThreeFingers.finger_width)
        min = std::min(min, finger_inside(kThreeFingers, grasp.pre_opening, p.z()) - std::abs(p.x()));
    }
    return min;
  };
  double flat = 1.0;
  for (const Grasp& grasp : grasp_candidates(stone, kFlatJaws, few).grasps)
    flat = std::min(flat, min_gap(grasp));
  EXPECT_LT(flat, 0.004) << "grasps of flat jaws take no heed of that";
  const GraspSet set = grasp_candidates(stone, kThreeFingers, few);
  ASSERT_GT(set.grasps.size(), 5u);
  for (const Grasp& grasp : set.grasps) EXPECT_GT(min_gap(grasp), 0.5 * few.finger_clearance);
}

/// Smallest height over the table [m] of a gripper's corners at T_W_T while it closes from one opening to
/// another.
double min_height(const GripperModel& gripper, const Pose& T_W_T, double from, double to) {
  double min = 1.0;
  for (double share = 0.0; share <= 1.0; share += 0.05)
    for (const GripperBox& box : gripper.boxes)
      for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3d sign(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
        const Eigen::Vector3d p_T =
            box_centre(gripper, box, from + share * (to - from)) + sign.cwiseProduct(box.size);
        min = std::min(min, (T_W_T * p_T).z());
      }
  return min;
}

/// Fingers clear the table by the padding of an approach, open, closed and on the way; some only just.
TEST(FingerReach, UsableGraspsClearTheTableWhileTheFingersClose) {
  constexpr double kPadding = 0.002;
  const Stone stone = reach_block();
  for (const Linkage linkage : {Linkage::kParallel, Linkage::kThreeFinger}) {
    PlanningScene scene;
    scene.robot = read_robot("ur10");
    scene.gripper = make_robotiq_3f(linkage);
    scene.T_F_T = Pose(Eigen::Translation3d(0, 0, 0.264));
    const Pose T_W_O = Pose(Eigen::Translation3d(0.70, -0.18, 0.03));
    scene.objects = {{"block", stone.pieces, T_W_O}};
    const GraspFinder finder(scene, stone, 0, T_W_O);
    ASSERT_GT(finder.at_pick().usable.size(), 20u);
    double lowest = 1.0, if_flat = 1.0;
    for (const int i : finder.at_pick().usable) {
      const Grasp& grasp = finder.set().grasps[static_cast<std::size_t>(i)];
      const Pose T_W_T = T_W_O * grasp.T_O_T;
      const GripperModel spaced = with_spacing(scene.gripper, grasp.spacing);
      const double height = min_height(spaced, T_W_T, grasp.pre_opening, grasp.opening);
      EXPECT_GE(height, kPadding - 1e-9) << grasp.pre_opening << " to " << grasp.opening;
      lowest = std::min(lowest, height);
      if_flat = std::min(if_flat, min_height(with_spacing(kFlatJaws, grasp.spacing), T_W_T, grasp.pre_opening,
                                             grasp.opening));
    }
    EXPECT_LT(lowest, 0.010);
    if (linkage == Linkage::kThreeFinger) {
      EXPECT_GT(if_flat, lowest + 0.004) << "flat jaws could go further down";
    }
  }
}

TEST(FingerReach, TheArmsCheckerSeesTheAdvancedFingers) {
  PlanningScene scene;
  scene.robot = read_robot("ur10");
  scene.T_F_T = Pose(Eigen::Translation3d(0, 0, 0.264));
  const Pose T_W_T = Eigen::Translation3d(0.7, 0.0, 0.03) *
                     Pose(Eigen::AngleAxisd(std::acos(-1.0), Eigen::Vector3d::UnitX()));
  const Joints seed = (Joints() << 0.0, -1.57, 1.57, -1.57, -1.57, 0.0).finished();
  const auto solutions = inverse(scene.robot, T_W_T * scene.T_F_T.inverse(), seed);
  CollisionRules rules;
  rules.opening = 0.07;
  rules.padding = 0.025;
  const CollisionChecker flat(scene, rules);
  const auto clear = std::find_if(solutions.begin(), solutions.end(),
                                  [&](const auto& solution) { return !flat.collides(solution.q); });
  ASSERT_NE(clear, solutions.end());
  scene.gripper = kThreeFingers;
  EXPECT_TRUE(CollisionChecker(scene, rules).collides(clear->q));
  rules.padding = 0.019;
  EXPECT_FALSE(CollisionChecker(scene, rules).collides(clear->q));
}

}  // namespace
}  // namespace stonestack::motion
