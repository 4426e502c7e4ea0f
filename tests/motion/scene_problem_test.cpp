#include "stonestack/motion/pick_and_place.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "motion/grasp_check.hpp"

namespace stonestack::motion {
namespace {

using ::testing::HasSubstr;

Stone problem_block(const Eigen::Vector3d& size) {
  Stone stone;
  stone.name = "block";
  stone.scan = stone.mesh = make_box(size);
  stone.pieces = {stone.scan};
  stone.mass = mass_properties(stone.scan, 2600.0);
  return stone;
}

/// A block in the field.
struct SceneProblemField {
  Stone stone;
  PlanningScene scene;
  PickAndPlaceTask task;

  explicit SceneProblemField(const Eigen::Vector3d& size = {0.10, 0.08, 0.07}) : stone(problem_block(size)) {
    scene.robot = read_robot("ur10");
    scene.T_F_T = Pose(Eigen::Translation3d(0, 0, 0.264));
    task.T_W_O_pick = Pose(Eigen::Translation3d(0.70, -0.18, 0.5 * size.z()));
    task.T_W_O_place = Pose(Eigen::Translation3d(0.70, 0.28, 0.5 * size.z()));
    scene.objects = {{"block", stone.pieces, task.T_W_O_pick}};
    task.stone = &stone;
    task.object = 0;
    task.q_start << 0.0, -1.8, 1.8, -1.57, -1.57, 0.0;
  }
  void add_box(const std::string& name, const Eigen::Vector3d& size, double x, double y, double z) {
    scene.objects.push_back({name, {make_box(size)}, Pose(Eigen::Translation3d(x, y, z))});
  }
};

TEST(SceneProblem, IsNoneWhereStonesTouch) {
  SceneProblemField field;
  EXPECT_EQ(scene_problem(field.scene, field.task), "");
  field.add_box("beside", {0.1, 0.1, 0.1}, 0.70 + 0.05 + 0.05 - 0.005, -0.18, 0.05);
  EXPECT_EQ(scene_problem(field.scene, field.task), "") << "measured poses err by more than 5 mm";
}

TEST(SceneProblem, NamesStonesThatLieInEachOther) {
  SceneProblemField field;
  field.add_box("other", {0.1, 0.1, 0.1}, 0.70 + 0.05 + 0.05 - 0.02, -0.18, 0.05);
  EXPECT_EQ(scene_problem(field.scene, field.task), "block and other overlap by 10 mm where they are");
  SceneProblemField around;
  around.add_box("shell", {0.5, 0.5, 0.5}, 0.70, -0.18, 0.0);
  EXPECT_THAT(scene_problem(around.scene, around.task), HasSubstr("block and shell overlap"));
}

TEST(SceneProblem, NamesAStoneInTheTable) {
  SceneProblemField field;
  field.task.T_W_O_pick.translation().z() -= 0.03;
  EXPECT_EQ(scene_problem(field.scene, field.task), "block reaches 30 mm into the table where it lies");
}

TEST(SceneProblem, NamesTheObjectThatTheArmTouches) {
  SceneProblemField field;
  field.add_box("cupboard", {0.5, 0.5, 0.3}, 0.5, 0.0, 0.6);
  EXPECT_THAT(scene_problem(field.scene, field.task), HasSubstr("at the start the arm stands in something"));
  EXPECT_THAT(scene_problem(field.scene, field.task), HasSubstr("cupboard"));
}

TEST(SceneProblem, NamesTheLimitThatTheArmBreaks) {
  SceneProblemField field;
  const Eigen::Vector3d most(1.5, 1.5, 0.5);
  field.scene.robot.fence = ArmFence{{-most, most}, field.scene.T_W_R, {Eigen::Vector3d::Zero()}};
  EXPECT_THAT(scene_problem(field.scene, field.task), HasSubstr("leaves the fence"));
}

/// A flat slab, which few grasps hold as it lies: 24 times as many are sampled, unless a lid covers it.
TEST(GraspFinder, SamplesNoMoreGraspsWhereALidObstructsAll) {
  const Eigen::Vector3d flat(0.12, 0.10, 0.022);
  SceneProblemField bare(flat), covered(flat);
  covered.add_box("lid", {0.6, 0.6, 0.02}, 0.70, -0.18, 0.15);
  const auto total = [](const SceneProblemField& field) {
    return GraspFinder(field.scene, field.stone, field.task.object, field.task.T_W_O_pick).at_pick().total;
  };
  const auto usual = static_cast<int>(cached_grasps(bare.stone, bare.scene.gripper)->grasps.size());
  ASSERT_GT(total(bare), usual) << "the slab is not flat enough to show anything";
  EXPECT_EQ(total(covered), usual);
}

}  // namespace
}  // namespace stonestack::motion
