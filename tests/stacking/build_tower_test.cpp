#include "stonestack/stacking/build_tower.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stacking/heard.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::stacking {
namespace {

using namespace simulation;  // the cell that the loop works in here

/// Distance from the truth at which the base of a tower is estimated to lie once it is placed, m.
double error_of_base(bool refine_camera) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  SimulationOptions world_options;
  world_options.seed = 7;
  SimulatedCell world(catalogue.stones, {1_stone, 2_stone, 3_stone}, robot, CellLayout{}, world_options);
  BuildOptions options;
  options.max_stones = 1;
  options.search.horizon = 1;
  options.refine_camera = refine_camera;
  Cell cell = world.cell();
  const RunResult result = build_tower(cell, catalogue, robot, options);
  EXPECT_EQ(result.height, 1) << result.ended;
  if (result.world.stack.empty()) return 1.0;
  const StoneEstimate& base = result.world.stack.front();
  const Truth truth = world.truth();
  return difference(base.T_W_O_at_rest, at(truth.T_W_O, base.stone)).translation;
}

TEST(BuildTower, TwoFirstViewsCorrectTheCamera) {
  EXPECT_LT(error_of_base(true), 0.0012);
  EXPECT_GT(error_of_base(false), 0.0020);  // the cell's hand-eye error: 1 mm and 0.3 deg
}

TEST(BuildTower, WithoutMeasuringAStoneIsEstimatedWhereItWasPlanned) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  for (const bool measure : {true, false}) {
    SimulationOptions world_options;
    world_options.seed = 7;
    SimulatedCell world(catalogue.stones, {1_stone, 2_stone, 3_stone}, robot, CellLayout{}, world_options);
    BuildOptions options;
    options.max_stones = 1;
    options.search.horizon = 1;
    options.measure_placed = measure;
    Cell cell = world.cell();
    const RunResult result = build_tower(cell, catalogue, robot, options);
    ASSERT_EQ(result.world.stack.size(), 1U) << result.ended;
    const PlacementRecord& placed = result.placements.front();
    EXPECT_EQ(placed.level, 1);
    const StoneEstimate& stone = result.world.stack.front();
    const double off = difference(stone.T_W_O_at_rest, placed.planned.T_W_O).translation;
    ASSERT_TRUE(placed.T_W_O_measured.has_value());
    EXPECT_EQ(placed.T_W_O_measured->matrix(), stone.T_W_O_seen.matrix());
    EXPECT_GT(difference(*placed.T_W_O_measured, stone.T_W_O_at_rest).translation, 1e-5)
        << "the record holds what was seen, not what settling makes of it";
    if (measure)
      EXPECT_GT(off, 1e-5) << "no stone comes to lie exactly as planned";
    else
      EXPECT_LT(off, 1e-9);
  }
}

TEST(BuildTower, AStoneThatTheGripperCannotCarryIsLeftOutAndNamed) {
  Catalogue catalogue = read_catalogue(data_path("stones"));
  catalogue.stones[1].mass.I_M *= 3.0 / catalogue.stones[1].mass.mass;
  catalogue.stones[1].mass.mass = 3.0;
  const RobotModel robot = read_robot("ur10");
  SimulationOptions world_options;
  world_options.seed = 7;
  SimulatedCell world(catalogue.stones, {1_stone, 2_stone}, robot, CellLayout{}, world_options);
  BuildOptions options;
  options.search.horizon = 1;
  Cell cell = world.cell();
  const RunResult result = build_tower(cell, catalogue, robot, options);
  EXPECT_EQ(result.height, 1);
  EXPECT_EQ(result.world.stack.front().stone, 2_stone);
  EXPECT_EQ(result.end, RunResult::End::kNoPose);
  EXPECT_THAT(result.ended, testing::HasSubstr("limestone_2: 3 kg, the fingers carry 2.5 kg"));
  const auto unfit = all_of<StonesUnfit>(result.events);
  ASSERT_EQ(unfit.size(), 1U);
  ASSERT_EQ(unfit[0].stones.size(), 1U);
  EXPECT_EQ(unfit[0].stones[0].stone, 1_stone);
  EXPECT_EQ(unfit[0].stones[0].note, "3 kg, the fingers carry 2.5 kg");
  const auto not_held = all_of<StonesNotHeld>(result.events);
  ASSERT_FALSE(not_held.empty());
  EXPECT_EQ(not_held[0].stones[0].stone, 1_stone);
  const auto searched = all_of<SearchedAtFriction>(result.events);
  ASSERT_FALSE(searched.empty());
  EXPECT_DOUBLE_EQ(searched[0].friction, 0.225) << "the lowest is not searched first";
  EXPECT_TRUE(searched[0].found);
  EXPECT_DOUBLE_EQ(searched[0].expected, 1.0);
}

/// An arm that was left low over the field, where nobody knows what lies: no transit begins there.
TEST(BuildTower, AGripperThatIsLowOverTheFieldBacksAwayFirst) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  SimulationOptions world_options;
  world_options.seed = 7;
  SimulatedCell world(catalogue.stones, {1_stone, 2_stone}, robot, CellLayout{}, world_options);
  Cell cell = world.cell();
  const Eigen::Vector2d& field = cell.layout.field_centre;
  Pose T_W_T = make_pose({field.x(), field.y(), 0.20});
  T_W_T.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const PlanningScene empty = make_planning_scene(cell.layout, robot, catalogue, {});
  const auto down = plan_transit(empty, cell.arm.state().q, Pose(T_W_T * cell.layout.T_F_T.inverse()), {});
  ASSERT_TRUE(down.has_value());
  ASSERT_EQ(cell.arm.follow(*down).status, MotionResult::Status::kDone);

  BuildOptions options;
  options.max_stones = 1;
  options.search.horizon = 1;
  const RunResult result = build_tower(cell, catalogue, robot, options);
  EXPECT_EQ(result.height, 1) << result.ended;
  EXPECT_EQ(all_of<BackedAway>(result.events).size(), 1U);
}

/// Moves the stone after one of its frames.
struct MovingCamera : DepthCamera {
  DepthCamera& camera;
  SimulatedCell& world;
  int after;
  MovingCamera(DepthCamera& inner, SimulatedCell& true_world, int frame)
      : camera(inner), world(true_world), after(frame) {}
  DepthFrame capture() override {
    DepthFrame frame = camera.capture();
    if (after-- == 0) {
      const Truth truth = world.truth();
      Pose T_W_O = at(truth.T_W_O, 1_stone);
      T_W_O.translation().y() -= 0.10;
      world.place(1_stone, T_W_O);
      world.wait(1.0);
    }
    return frame;
  }
};

TEST(BuildTower, AStoneThatIsMovedBetweenTheFirstViewsIsFound) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  for (int frame = 0; frame < 3; ++frame) {
    SimulationOptions world_options;
    world_options.seed = 7;
    SimulatedCell world(catalogue.stones, {1_stone}, robot, CellLayout{}, world_options);
    MovingCamera camera(world.cell().camera, world, frame);
    const Cell inner = world.cell();
    Cell cell{inner.arm, inner.gripper, inner.force_torque, camera, inner.clock, inner.layout};
    BuildOptions options;
    options.max_stones = 1;
    options.search.horizon = 1;
    options.measure_friction = false;
    const RunResult result = build_tower(cell, catalogue, robot, options);
    EXPECT_EQ(result.height, 1) << "moved after frame " << frame << ": " << result.ended;
    EXPECT_LT(camera.after, 0) << "it was moved";
  }
}

}  // namespace
}  // namespace stonestack::stacking
