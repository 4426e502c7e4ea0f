#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stonestack/core/data.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"

/// What a run says of stones of which detection is not sure.
namespace stonestack::stacking {
namespace {

using testing::ContainsRegex;

TEST(Doubtful, AStoneWithATwinIsNamedOnceARunAndNoOther) {
  Catalogue catalogue = read_catalogue(data_path("stones"));
  Stone twin = catalogue.stones[1];
  twin.name = "twin_of_limestone_2";
  catalogue.stones.push_back(twin);
  for (Stone& stone : catalogue.stones) {  // none can be carried: the run looks and ends
    stone.mass.I_M *= 3.0 / stone.mass.mass;
    stone.mass.mass = 3.0;
  }
  const RobotModel robot = read_robot("ur10");
  SimulationOptions world_options;
  world_options.seed = 7;
  SimulatedCell world(catalogue.stones, {1, 3}, robot, CellLayout{}, world_options);
  std::vector<std::string> doubts;
  BuildHooks hooks;
  hooks.report = [&](const std::string& line) {
    if (line.find("another stone of like shape") != std::string::npos) doubts.push_back(line);
  };
  Cell cell = world.cell();
  const RunResult result = build_tower(cell, catalogue, robot, {}, hooks);
  EXPECT_EQ(result.belief.loose.size(), 2U) << result.ended;
  ASSERT_FALSE(doubts.empty());
  for (std::size_t i = 0; i < doubts.size(); ++i) {
    EXPECT_THAT(doubts[i],
                ContainsRegex("^(limestone_2|twin_of_limestone_2) may be turned .* certainty of (4|5).? %$"));
    for (std::size_t k = 0; k < i; ++k) EXPECT_NE(doubts[i], doubts[k]) << "more than one look shows it";
  }
  EXPECT_LE(doubts.size(), 2U) << "either name of the same stone";
}

}  // namespace
}  // namespace stonestack::stacking
