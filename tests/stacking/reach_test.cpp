#include "stacking/reach.hpp"

#include <gtest/gtest.h>

#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::stacking {
namespace {

/// One stone in the middle of the field, in its firmest resting pose.
struct ReachBench {
  Catalogue catalogue = read_catalogue(data_path("stones"));
  CellLayout layout;
  RobotModel robot = read_robot("ur10");
  Arrangement arrangement;

  ReachBench() {
    const Stone& stone = catalogue.stones[1];
    Pose T_W_O = make_pose(Eigen::Vector3d::Zero(), rest_poses(stone).front().R_W_O);
    double lowest = 0.0;
    for (const auto& p : stone.scan.vertices) lowest = std::min(lowest, (T_W_O * p).z());
    T_W_O.translation() << layout.field_centre, -lowest;
    arrangement.loose.push_back({1_stone, T_W_O});
  }
  [[nodiscard]] Reach reach(const MotionOptions& options) const {
    return {arrangement, make_planning_scene(layout, robot, catalogue, arrangement), catalogue, options};
  }
  [[nodiscard]] bool held_with(double padding) const {
    MotionOptions options;
    options.approach_padding = padding;
    const PlanningScene scene = make_planning_scene(layout, robot, catalogue, arrangement);
    return GraspFinder(scene, catalogue.stones[1], 0, arrangement.loose[0].T_W_O, options)
        .at_pick()
        .can_be_held();
  }
};

/// The last millimetre decides whether a gripper gets hold of a flat stone: where none does with the usual
/// clearance under the finger tips, some may with less.
TEST(Reach, AStoneThatIsOutOfReachIsGraspedNearerToTheTable) {
  const ReachBench bench;
  double padding = 0.002;
  while (bench.held_with(padding) && padding < 0.2) padding *= 1.9;
  ASSERT_TRUE(bench.held_with(0.5 * padding)) << padding;
  MotionOptions options;
  options.approach_padding = padding;
  Reach reach = bench.reach(options);
  EXPECT_TRUE(reach.is_low(1_stone));
  EXPECT_TRUE(reach.at_pick(1_stone).can_be_held());
  EXPECT_DOUBLE_EQ(reach.options_for(1_stone).approach_padding, 0.5 * padding);
  EXPECT_LT(reach.options_for(1_stone).approach_speed, options.approach_speed) << "it approaches by force";

  const MotionOptions usual;
  Reach near = bench.reach(usual);
  EXPECT_FALSE(near.is_low(1_stone));
  EXPECT_DOUBLE_EQ(near.options_for(1_stone).approach_padding, usual.approach_padding);
}

TEST(Reach, GraspsThatFailedServeReorientingOnceTheyAreRetried) {
  const ReachBench bench;
  const MotionOptions options;
  Reach reach = bench.reach(options);
  const PlanningScene scene =
      make_planning_scene(bench.layout, bench.robot, bench.catalogue, bench.arrangement);
  const GraspFinder finder(scene, bench.catalogue.stones[1], 0, bench.arrangement.loose[0].T_W_O, options);
  std::vector<Pose> all;
  for (const auto& grasp : finder.set().grasps) all.push_back(grasp.T_O_T);
  ASSERT_FALSE(all.empty());
  Pose T_W_O = bench.arrangement.loose[0].T_W_O;
  T_W_O.translation().head<2>() = bench.layout.site;
  EXPECT_FALSE(reach.by_reorienting(1_stone, T_W_O, {}, all, {}));
  EXPECT_TRUE(reach.by_reorienting(1_stone, T_W_O, {}, {}, {}));
}

TEST(Reach, SaysWhatTheGraspsOfARefusedTargetMeet) {
  const ReachBench bench;
  const MotionOptions options;
  Reach reach = bench.reach(options);
  const Pose T_W_O = bench.arrangement.loose[0].T_W_O;
  ASSERT_TRUE(reach.in_one_go(1_stone, Eigen::Translation3d(0.0, 0.1, 0.0) * T_W_O, {}));
  EXPECT_EQ(reach.refusal(1_stone), "");
  EXPECT_FALSE(reach.in_one_go(1_stone, Eigen::Translation3d(5.0, 0.0, 0.0) * T_W_O, {}));
  EXPECT_NE(reach.refusal(1_stone).find("out of reach at the target"), std::string::npos)
      << reach.refusal(1_stone);
}

}  // namespace
}  // namespace stonestack::stacking
