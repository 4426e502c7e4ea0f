#include "stonestack/stacking/build_tower.hpp"

#include <gtest/gtest.h>

#include "stonestack/core/data.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"

namespace stonestack {
namespace {

/// How far from the truth the base of a tower is believed to lie, m, after it has been placed.
double error_of_base(bool refine_camera) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  SimulationOptions world_options;
  world_options.seed = 7;
  SimulatedCell world(catalogue.stones, {1, 2, 3}, robot, CellLayout{}, world_options);
  BuildOptions options;
  options.most_stones = 1;
  options.search.horizon = 1;
  options.refine_camera = refine_camera;
  Cell cell = world.cell();
  const RunResult result = build_tower(cell, catalogue, robot, options);
  EXPECT_EQ(result.height, 1) << result.ended;
  if (result.belief.stack.empty()) return 1.0;
  const PlacedStone& base = result.belief.stack.front();
  return difference(base.T_W_O, world.truth().T_W_O[static_cast<std::size_t>(base.stone)]).translation;
}

TEST(BuildTower, TwoFirstLooksCorrectTheCamera) {
  EXPECT_LT(error_of_base(true), 0.0012);
  EXPECT_GT(error_of_base(false), 0.0020);  // the cell's hand-eye error: 1 mm and 0.3 deg
}

}  // namespace
}  // namespace stonestack
