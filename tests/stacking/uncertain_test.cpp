#include <gtest/gtest.h>

#include <set>

#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"

/// Report of stones of which detection is not sure.
namespace stonestack::stacking {
namespace {

using namespace simulation;  // the cell that the loop works in here

TEST(Uncertain, AStoneWithATwinIsNamedOnceARunAndNoOther) {
  Catalogue catalogue = read_catalogue(data_path("stones"));
  Stone twin = catalogue.stones[1];
  twin.name = "twin_of_limestone_2";
  const StoneIndex twin_index(catalogue.stones.size());
  catalogue.stones.push_back(twin);
  for (Stone& stone : catalogue.stones) {  // none can be carried: the run observes and ends
    stone.mass.I_M *= 3.0 / stone.mass.mass;
    stone.mass.mass = 3.0;
  }
  const RobotModel robot = read_robot("ur10");
  SimulationOptions world_options;
  world_options.seed = 7;
  SimulatedCell world(catalogue.stones, {1_stone, 3_stone}, robot, CellLayout{}, world_options);
  Cell cell = world.cell();
  const RunResult result = build_tower(cell, catalogue, robot, {});
  EXPECT_EQ(result.world.loose.size(), 2U) << result.ended;
  const auto uncertain = all_of<StoneUncertain>(result.events);
  ASSERT_FALSE(uncertain.empty());
  std::set<StoneIndex> named;
  for (const StoneUncertain& seen : uncertain) {
    EXPECT_TRUE(seen.stone == 1_stone || seen.stone == twin_index) << seen.stone;
    EXPECT_GT(seen.certainty, 0.395);
    EXPECT_LT(seen.certainty, 0.595);
    EXPECT_TRUE(named.insert(seen.stone).second) << "more than one view shows it";
  }
}

}  // namespace
}  // namespace stonestack::stacking
