#include "motion/grasp/pad_press.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/constants.hpp"
#include "motion/pick_and_place/pick_candidates.hpp"

namespace stonestack::motion {
namespace {

const GripperModel kPressGripper = make_robotiq_3f();
const Eigen::Vector3d kSize(0.10, 0.16, 0.06);

Stone box_stone(double density) {
  Stone stone;
  stone.name = "box";
  stone.scan = stone.mesh = make_box(kSize);
  stone.pieces = {stone.scan};
  stone.mass = mass_properties(stone.scan, density);
  return stone;
}

/// From above, the middle of the pads at the middle of the box, the gripper tilted about y by `tilt`.
Grasp middle_grasp(double tilt) {
  Grasp grasp;
  grasp.T_O_T.linear() = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()).toRotationMatrix() *
                         Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitY()).toRotationMatrix();
  grasp.T_O_T.translation() = grasp.T_O_T.linear() * Eigen::Vector3d(0, 0, 0.5 * kPressGripper.pad_length);
  grasp.opening = tilt == 0.0 ? kSize.x() : std::hypot(kSize.x(), kSize.z());
  grasp.pre_opening = grasp.opening + 0.02;
  grasp.spacing = kPressGripper.finger_spacing;
  return grasp;
}

PadPress press(const Stone& stone, const Grasp& grasp) {
  return {sample_surface(stone.scan, 0.002), stone.mass, kPressGripper, grasp};
}

TEST(PadPress, FlatFacesAreHeldByTheRubbersShear) {
  const Stone stone = box_stone(2600.0);
  const PadPress pads = press(stone, middle_grasp(0.0));
  const double area = kPressGripper.finger_width * kPressGripper.pad_length;
  EXPECT_NEAR(pads.deepest(0), kPressGripper.force / (kPressGripper.pad_stiffness * area), 5e-5);
  EXPECT_NEAR(pads.deepest(1), 0.5 * kPressGripper.force / (kPressGripper.pad_stiffness * area), 5e-5);
  const PadPress::Load load = pads.bear(Eigen::Vector3d::UnitZ(), 1.5);
  EXPECT_EQ(load.share, 1.5);
  EXPECT_NEAR(load.moved, kGravity * stone.mass.mass / (3 * kPressGripper.pad_shear * area), 2e-5);
  EXPECT_LT(load.turned, 0.002);
}

TEST(PadPress, BearsNoMoreThanFriction) {
  // Two sides press with 60 N each; friction 0.5 bears 60 N.
  const double volume = kSize.prod();
  for (const auto& [weight, share] : {std::pair(50.0, 1.0), {100.0, 0.5}, {150.0, 0.0}}) {
    const Stone stone = box_stone(weight / kGravity / volume);
    EXPECT_EQ(press(stone, middle_grasp(0.0)).bear(Eigen::Vector3d::UnitZ(), 1.5).share, share) << weight;
  }
}

TEST(PadPress, AnEdgePressesDeepAndHoldsLess) {
  const Stone stone = box_stone(2600.0);
  const double tilt = std::atan2(kSize.z(), kSize.x());  // two edges of the box between the pads
  const PadPress pads = press(stone, middle_grasp(tilt));
  // A wedge with a right angle, its edge along the pad: depth^2 / (2 sin cos) of area on both flanks
  // together.
  const double flank = std::sin(tilt) * std::cos(tilt);
  EXPECT_NEAR(
      pads.deepest(0),
      std::sqrt(2 * kPressGripper.force * flank / (kPressGripper.pad_stiffness * kPressGripper.finger_width)),
      4e-4);
  const double flat = press(stone, middle_grasp(0.0)).bear(Eigen::Vector3d::UnitZ(), 1.0).moved;
  EXPECT_GT(pads.bear(Eigen::Vector3d::UnitZ(), 1.0).moved, 2 * flat);
}

TEST(PickCandidates, AFirmGraspComesBeforeALooseOneThatScoresMore) {
  const Stone stone = box_stone(2000.0);
  PlanningScene scene;
  scene.robot = read_robot("ur10");
  PickAndPlaceTask task;
  task.stone = &stone;
  task.T_W_O_pick = make_pose(Eigen::Vector3d(0.6, 0.0, 0.2));
  task.T_W_O_place = make_pose(Eigen::Vector3d(0.6, 0.2, 0.3));
  GraspSet set;
  set.grasps = {middle_grasp(std::atan2(kSize.z(), kSize.x())), middle_grasp(0.0)};
  set.grasps[0].score = 0.9;
  set.grasps[1].score = 0.5;
  GraspCheck check;
  check.usable = {0, 1};
  check.total = 2;
  PickCandidates candidates(scene, task, {}, set, check, [](int, const Joints&) { return true; });
  const auto first = candidates.next();
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->grasp, 1);
  double last = first->cost;
  int given = 1;
  for (auto next = candidates.next(); next; next = candidates.next(), ++given) {
    EXPECT_GE(next->cost, last) << "cheapest first";
    last = next->cost;
  }
  EXPECT_GE(given, 2) << "the loose one is the last resort, but it is there";

  // The nearest inverse solution is blocked: other inverse solutions take its place.
  const auto free = [&](int, const Joints& q) { return (q - first->q_place).norm() > 1e-6; };
  PickCandidates others(scene, task, {}, set, check, free);
  int left = 0;
  for (auto next = others.next(); next; next = others.next(), ++left)
    EXPECT_GT((next->q_place - first->q_place).norm(), 1e-6);
  EXPECT_GE(left, given);
}

}  // namespace
}  // namespace stonestack::motion
