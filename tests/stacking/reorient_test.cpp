#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "motion/regrasp.hpp"
#include "stacking/heard.hpp"
#include "stacking/saved_states.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"
#include "temporary_folder.hpp"

/// Actions of the loop on a stone that lies on a side from which no grasp brings it to its place.
namespace stonestack::stacking {
namespace {

using namespace simulation;  // the cell that the loop works in here

constexpr StoneIndex kStone = 1_stone;  // limestone_2

/// On the table, in that resting pose, its centre of mass over `p_W`.
Pose standing(const Stone& stone, const RestPose& rest, const Eigen::Vector2d& p_W) {
  Pose T_W_O(rest.R_W_O);
  double lowest = 1.0;
  for (const auto& vertex : stone.scan.vertices) lowest = std::min(lowest, (T_W_O * vertex).z());
  const Eigen::Vector3d p_W_M = T_W_O * stone.mass.p_O_M;
  return Eigen::Translation3d(p_W.x() - p_W_M.x(), p_W.y() - p_W_M.y(), 0.001 - lowest) * T_W_O;
}

TEST(Reorient, AStoneThatLiesOnTheWrongSideIsReorientedAndPlaced) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const Stone& stone = catalogue[kStone];
  const RobotModel robot = read_robot("ur10");
  SimulationOptions world_options;
  world_options.seed = 7;
  SimulatedCell world(catalogue.stones, {kStone}, robot, CellLayout{}, world_options);
  const auto rests = rest_poses(stone);
  ASSERT_GT(rests[0].tilt, 0.6) << "its broad side";
  ASSERT_LT(rests[1].tilt, 0.4) << "the side opposite";
  world.place(kStone, standing(stone, rests[1], {0.70, -0.12}));
  world.wait(2.0);
  BuildOptions options;
  options.search.horizon = 1;
  // On the side that it lies on the stone bears 0.23 g, on its broad side 0.25 g, on the others less: a base
  // that shall bear 0.24 g stands on its broad side. Turning is thought of at the last friction at the
  // latest.
  options.search.min_margin = 0.24;  // g
  options.search.friction = 0.35;
  options.max_friction = 0.475;
  options.save_states = true;
  BuildHooks hooks;
  hooks.states_folder = test::states_folder(test::temporary_folder(), "reorient");
  Cell cell = world.cell();
  const RunResult result = build_tower(cell, catalogue, robot, options, hooks);
  const std::string message = test::words(result.events, catalogue);
  const auto set_down = all_of<SetDownBegun>(result.events);
  ASSERT_FALSE(set_down.empty()) << message;
  EXPECT_TRUE(set_down[0].reorients);
  EXPECT_EQ(set_down[0].placement.stone, kStone);
  ASSERT_EQ(result.placements.size(), 2U) << message;
  EXPECT_EQ(result.placements[0].outcome, PlacementRecord::Outcome::kReoriented);
  EXPECT_EQ(result.placements[1].outcome, PlacementRecord::Outcome::kPlaced);
  EXPECT_EQ(result.height, 1) << message;
  const Truth truth = world.truth();
  const Eigen::Vector3d n_O_up = at(truth.T_W_O, kStone).linear().row(2).transpose();
  EXPECT_GT(n_O_up.dot(rests[0].R_W_O.inverse() * Eigen::Vector3d::UnitZ()), 0.95) << "on its broad side";
  EXPECT_THAT(test::decisions(hooks.states_folder, catalogue, robot),
              testing::ElementsAre("place", "reorient", "place", "stop"))
      << "of each saved state: no motion places it in one go, so it is reoriented first";
}

}  // namespace
}  // namespace stonestack::stacking
