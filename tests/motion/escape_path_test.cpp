#include <gtest/gtest.h>

#include "kinematics/inverse.hpp"
#include "motion/transit.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

using hardware::CellLayout;

constexpr double kHalfTurn = 3.14159265358979323846;

PlanningScene scene_with(const std::vector<SceneObject>& objects) {
  PlanningScene scene;
  scene.robot = read_robot("ur10");
  scene.T_F_T = CellLayout().T_F_T;
  scene.objects = objects;
  return scene;
}

SceneObject scene_box_at(const std::string& name, const Eigen::Vector3d& size, const Eigen::Vector3d& p_W) {
  return {name, {make_box(size)}, make_pose(p_W)};
}

/// Fingers down and wide open, tips at p_W.
Joints above_in_scene(const PlanningScene& scene, const Eigen::Vector3d& p_W) {
  Pose T_W_T = Pose::Identity();
  T_W_T.linear() = Eigen::AngleAxisd(kHalfTurn, Eigen::Vector3d::UnitX()).toRotationMatrix();
  T_W_T.translation() = p_W;
  Joints near_down;
  near_down << 0, -0.5 * kHalfTurn, 0.5 * kHalfTurn, -0.5 * kHalfTurn, -0.5 * kHalfTurn, 0;
  const auto found = inverse(scene.robot, T_W_T * scene.T_F_T.inverse(), near_down);
  return found.empty() ? Joints(Joints::Constant(std::nan(""))) : found.front().q;
}

Eigen::Vector3d tip(const PlanningScene& scene, const Joints& q) {
  return (forward(scene.robot, q) * scene.T_F_T).translation();
}

/// A stone as high as the fingers are long stands within the gripper's width.
const SceneObject& neighbour() {
  static const SceneObject made = scene_box_at("neighbour", {0.04, 0.30, 0.10}, {0.785, 0.0, 0.05});
  return made;
}

TEST(EscapePath, AGripperThatIsClearStaysWhereItIs) {
  const PlanningScene scene = scene_with({});
  const Joints start = above_in_scene(scene, {0.7, 0.0, 0.15});
  const auto path = escape_path(scene, start);
  ASSERT_TRUE(path.has_value());
  ASSERT_EQ(path->size(), 1U);
  EXPECT_EQ(path->front(), start);
}

TEST(EscapePath, AFingerBesideANeighbourIsRetractedAsFarAsNeeded) {
  const PlanningScene scene = scene_with({neighbour()});
  const Joints start = above_in_scene(scene, {0.7, 0.0, 0.02});
  CollisionRules rules;
  rules.padding = 0.002;
  rules.self_padding = 0.002;
  const CollisionChecker checker(scene, rules);
  ASSERT_TRUE(checker.collides(start)) << checker.clearance(start).distance;
  const Joints goal = above_in_scene(scene, {0.4, 0.4, 0.4});
  EXPECT_FALSE(plan_transit(scene, start, goal, {}).has_value()) << "no transit begins there";
  const auto path = escape_path(scene, start);
  ASSERT_TRUE(path.has_value());
  EXPECT_FALSE(checker.collides(path->back()));
  const Eigen::Vector3d moved = tip(scene, path->back()) - tip(scene, start);
  EXPECT_LT(moved.head<2>().norm(), 1e-3) << "back is up here";
  EXPECT_GT(moved.z(), 0.01);
  EXPECT_LE(moved.z(), 0.121);
  EXPECT_TRUE(plan_transit(scene, path->back(), goal, {}).has_value());
}

TEST(EscapePath, NoneLeadsDeeperOrPastWhatIsAbove) {
  const SceneObject lid = scene_box_at("lid", {0.5, 0.5, 0.02}, {0.7, 0.0, 0.22});
  const PlanningScene scene = scene_with({neighbour(), lid});
  EXPECT_FALSE(escape_path(scene, above_in_scene(scene, {0.7, 0.0, 0.02})).has_value());
}

}  // namespace
}  // namespace stonestack::motion
