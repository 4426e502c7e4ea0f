#include <gtest/gtest.h>

#include "motion/collision.hpp"
#include "motion/grasp_check.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

using hardware::CellLayout;

/// A UR10 whose hand points straight down, 8 mm over the table; a lamp 8 mm beside the palm.
struct NearThings {
  PlanningScene scene;
  Joints q = (Joints() << 0.0, -1.75, 1.85, -1.6708, -1.5708, 0.0).finished();
  Pose T_W_T = Pose::Identity();

  NearThings() {
    scene.robot = read_robot("ur10");
    scene.T_F_T = CellLayout().T_F_T;
    const double high = (forward(scene.robot, q) * scene.T_F_T).translation().z();
    scene.T_F_T.translation().z() += high - 0.008;  // a hand on a long tube
    T_W_T = forward(scene.robot, q) * scene.T_F_T;
    const Mesh box = make_box({0.05, 0.05, 0.05});
    scene.objects = {{"lamp", {box}, T_W_T * Pose(Eigen::Translation3d(0.0675 + 0.008 + 0.025, 0.0, -0.16))}};
  }
  [[nodiscard]] bool meets(std::vector<PairPadding> paddings, double padding = 0.010) {
    scene.paddings = std::move(paddings);
    CollisionRules rules;
    rules.padding = padding;
    rules.opening = 0.0;
    return CollisionChecker(scene, rules).collides(q);
  }
};

TEST(PaddingBetween, AUserAsksForMoreOrLessBetweenTwoThings) {
  NearThings near;
  const PairPadding lamp{"hand", "lamp", 0.004}, table{"hand", "table", 0.004};
  EXPECT_TRUE(near.meets({}));
  EXPECT_TRUE(near.meets({lamp})) << "the table is as near";
  EXPECT_TRUE(near.meets({table}));
  EXPECT_FALSE(near.meets({lamp, table}));
  EXPECT_TRUE(near.meets({{"arm", "lamp", 0.004}, {"held", "table", 0.004}}));
  EXPECT_FALSE(near.meets({}, 0.002));
  EXPECT_TRUE(near.meets({{"hand", "lamp", 0.009}}, 0.002));
  EXPECT_TRUE(near.meets({{"hand", "table", 0.009}}, 0.002));
  EXPECT_FALSE(near.meets({{"forearm", "lamp", 0.009}}, 0.002));
  EXPECT_TRUE(near.meets({{"forearm", "lamp", 1.0}}, 0.002)) << "a link by its name";
  EXPECT_TRUE(near.meets({{"arm", "lamp", 1.0}}, 0.002));
  EXPECT_FALSE(near.meets({{"arm", "lamp", 1.0}, {"forearm", "lamp", 0.0}, {"arm", "lamp", 0.0}}, 0.002))
      << "the last that names both counts";
  EXPECT_FALSE(near.meets({{"hand", "lamp", 0.009}, {"hand", "table", 0.009}}, 0.0)) << "contact is wanted";
}

TEST(PaddingBetween, GraspsKeepIt) {
  PlanningScene scene;
  scene.robot = read_robot("ur10");
  scene.T_F_T = CellLayout().T_F_T;
  Stone stone;
  stone.name = "box";
  stone.scan = stone.mesh = make_box({0.08, 0.12, 0.08});
  stone.pieces = {stone.scan};
  stone.mass = mass_properties(stone.scan, 2000.0);
  scene.objects = {{"box", stone.pieces, make_pose(Eigen::Vector3d(0.7, 0.0, 0.04))},
                   {"lamp", {make_box({0.1, 0.1, 0.1})}, make_pose(Eigen::Vector3d(0.7, 0.2, 0.05))}};
  PickAndPlaceTask task;
  task.stone = &stone;
  task.object = 0;
  task.T_W_O_pick = scene.objects[0].T_W_object;
  task.T_W_O_place = make_pose(Eigen::Vector3d(0.7, -0.2, 0.1));
  const auto refused = [&](std::vector<PairPadding> paddings, GraspFault fault) {
    scene.paddings = std::move(paddings);
    return check_grasps(scene, task).refused[static_cast<std::size_t>(fault)];
  };
  EXPECT_GT(refused({{"hand", "table", 0.02}}, GraspFault::kTableAtPick),
            refused({}, GraspFault::kTableAtPick));
  EXPECT_GT(refused({{"hand", "lamp", 0.08}}, GraspFault::kObjectAtPick),
            refused({}, GraspFault::kObjectAtPick));
  EXPECT_EQ(refused({{"arm", "table", 0.02}}, GraspFault::kTableAtPick),
            refused({}, GraspFault::kTableAtPick));
}

}  // namespace
}  // namespace stonestack::motion
