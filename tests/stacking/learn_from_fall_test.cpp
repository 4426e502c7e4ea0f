#include <gtest/gtest.h>

#include "stacking/heard.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"

/// Conclusions of the loop from a stone that did not stay where it was let go of.
namespace stonestack::stacking {
namespace {

using namespace simulation;  // the cell that the loop works in here

/// Throws the first stone that is up on another back to where it lay, before it looks.
struct ThrowingCamera : DepthCamera {
  DepthCamera& camera;
  SimulatedCell& world;
  Truth before;
  bool thrown = false;
  ThrowingCamera(DepthCamera& c, SimulatedCell& w) : camera(c), world(w), before(w.truth()) {}
  DepthFrame capture() override {
    const Truth truth = world.truth();
    for (std::size_t k = 0; !thrown && k < truth.T_W_O.size(); ++k) {
      if (truth.T_W_O[k].translation().z() - before.T_W_O[k].translation().z() < 0.03) continue;
      world.place(StoneIndex(k), before.T_W_O[k]);
      thrown = true;
    }
    return camera.capture();
  }
};

TEST(LearnFromFall, FrictionsThatContradictTheFallAreLessLikely) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  SimulationOptions world_options;
  world_options.seed = 7;
  SimulatedCell world(catalogue.stones, {1_stone, 2_stone}, robot, CellLayout{}, world_options);
  const Cell devices = world.cell();
  ThrowingCamera camera(devices.camera, world);
  Cell cell{devices.arm, devices.gripper, devices.force_torque, camera, devices.clock, devices.layout};
  BuildOptions options;
  options.search.horizon = 1;
  options.measure_friction = false;  // the fall alone
  const RunResult result = build_tower(cell, catalogue, robot, options);
  const std::string message = test::words(result.events, catalogue);
  ASSERT_TRUE(camera.thrown) << message;
  ASSERT_GE(result.placements.size(), 3U) << message;
  EXPECT_EQ(result.placements[1].outcome, PlacementRecord::Outcome::kFallen);
  // It was sure with all but little friction, so 0.225, 0.35 and 0.475 lose three quarters each.
  const auto learned = all_of<FrictionUpdated>(result.events);
  ASSERT_EQ(learned.size(), 1U);
  EXPECT_DOUBLE_EQ(learned[0].friction.frictions[0], 0.1);
  EXPECT_GT(learned[0].friction.weights[0], 0.105);
  EXPECT_EQ(result.height, 2) << message;
}

}  // namespace
}  // namespace stonestack::stacking
