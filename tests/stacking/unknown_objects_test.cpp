#include <gtest/gtest.h>

#include "rooms.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"

namespace stonestack::stacking {
namespace {

/// A run that takes nothing but the first look at two stones and `foreign` objects.
struct FirstLook {
  Catalogue catalogue = read_catalogue(data_path("stones"));
  RobotModel robot = read_robot("ur10");
  simulation::SimulatedCell world;
  RunResult result;

  explicit FirstLook(int foreign)
      : world(catalogue.stones, first_stones(2), robot, CellLayout{}, with_foreign(foreign)) {
    Cell cell = world.cell();
    BuildOptions options;
    options.max_stones = 1;
    options.search.horizon = 1;
    result = build_tower(cell, catalogue, robot, options);
  }
  static simulation::SimulationOptions with_foreign(int count) {
    simulation::SimulationOptions options;
    options.seed = 5;
    options.foreign_objects = count;
    options.clearance = 0.02;
    return options;
  }
};

TEST(UnknownObjects, AreSeenWhereTheyLie) {
  const FirstLook look(2);
  const auto seen = all_of<UnknownObjectSeen>(look.result.events);
  ASSERT_EQ(seen.size(), 2U);
  const auto truth = look.world.truth();
  for (std::size_t k = look.catalogue.stones.size(); k < truth.T_W_O.size(); ++k) {
    const Eigen::Vector2d p_W = truth.T_W_O[k].translation().head<2>();
    double nearest = 1.0;
    for (const UnknownObjectSeen& object : seen) nearest = std::min(nearest, (object.p_W - p_W).norm());
    EXPECT_LT(nearest, 0.012) << p_W.transpose();
  }
  for (const UnknownObjectSeen& object : seen) {
    EXPECT_GT(object.highest, 0.02);
    EXPECT_LT(object.highest, 0.15);
  }
}

TEST(UnknownObjects, StonesAreNone) {
  const FirstLook look(0);
  EXPECT_EQ(look.result.height, 1) << look.result.ended;
  EXPECT_TRUE(all_of<UnknownObjectSeen>(look.result.events).empty());
}

}  // namespace
}  // namespace stonestack::stacking
