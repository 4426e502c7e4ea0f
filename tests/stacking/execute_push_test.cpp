#include <gtest/gtest.h>

#include "motion/push.hpp"
#include "motion/regrasp.hpp"
#include "stacking/execute.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/observe.hpp"

/// Pushes carried out in the simulated cell.
namespace stonestack::stacking {
namespace {

using namespace simulation;

/// How far a stone moves towards +x that lies `further` (m) along x than the plan has it, and is to move 50
/// mm.
double pushed_from(double further) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  SimulationOptions options = options_of_cell("ideal");
  options.seed = 3;
  CellLayout layout;
  layout.linkage = options.linkage;
  SimulatedCell world(catalogue.stones, {1_stone}, robot, layout, options);
  Pose T_W_O = make_pose(Eigen::Vector3d::Zero(), rest_poses(catalogue[1_stone]).front().R_W_O);
  double low = 1.0;
  for (const auto& p : catalogue[1_stone].scan.vertices) low = std::min(low, (T_W_O * p).z());
  T_W_O.translation() << layout.field_centre, -low;
  world.place(1_stone, T_W_O);
  world.wait(1.0);
  const Pose before = world.truth().T_W_O[1];
  Cell cell = world.cell();
  PushTask task;
  task.stone = &catalogue[1_stone];
  task.object = 0;
  task.T_W_O = Eigen::Translation3d(-further, 0, 0) * before;
  task.p_W_shift << 0.05, 0.0;
  task.q_start = cell.arm.state().q;
  const PlanningScene scene = make_planning_scene(layout, robot, catalogue, {{}, {{1_stone, task.T_W_O}}});
  const PickAndPlacePlan plan = plan_push(scene, task);
  EXPECT_EQ(plan.status, PickAndPlacePlan::Status::kPlanned) << plan.reason;
  const ExecutionResult done = execute_push(plan, catalogue[1_stone], scene, cell, {}, nullptr);
  EXPECT_EQ(done.status, ExecutionResult::Status::kReleased) << done.reason;
  EXPECT_EQ(done.reason, "");
  world.wait(1.0);
  const Pose after = world.truth().T_W_O[1];
  return (after * task.stone->mass.p_O_M - before * task.stone->mass.p_O_M).x();
}

TEST(ExecutePush, AStoneMovesAsFarWhereverItIsFelt) {
  const double as_seen = pushed_from(0.0);
  EXPECT_GT(as_seen, 0.025) << "it turns, too";
  EXPECT_LT(as_seen, 0.055);
  EXPECT_NEAR(pushed_from(-0.004), as_seen, 0.004);
  EXPECT_NEAR(pushed_from(0.015), as_seen, 0.004);
}

}  // namespace
}  // namespace stonestack::stacking
