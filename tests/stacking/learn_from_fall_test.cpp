#include <gtest/gtest.h>

#include "physics/shape.hpp"
#include "stacking/box_shape.hpp"
#include "stacking/choose_action.hpp"
#include "stacking/heard.hpp"
#include "stacking/learn.hpp"
#include "stonestack/core/error.hpp"
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

/// A box of 80 x 80 x 40 mm whose top (or underside) rises along x by `slope`.
Mesh sloping_box(double slope, bool top) {
  Mesh mesh = make_box({0.08, 0.08, 0.04});
  for (Eigen::Vector3d& p : mesh.vertices)
    if ((p.z() > 0) == top) p.z() += slope * p.x();
  return mesh;
}

/// On a slope of 0.15 a stone rests that others can be put upon safely.
struct SlopeScene {
  static constexpr double kSlope = 0.15;
  Catalogue catalogue;
  RobotModel robot = read_robot("ur10");
  BuildOptions options;
  Models models;
  RunMemory memory;
  WorldEstimate seen;

  SlopeScene() {
    const std::vector<Mesh> meshes = {sloping_box(kSlope, true), sloping_box(kSlope, false),
                                      make_box({0.06, 0.06, 0.03})};
    for (const Mesh& mesh : meshes) {
      Stone stone;
      stone.name = concat("stone_", catalogue.stones.size());
      stone.scan = mesh;
      stone.mass = mass_properties(mesh, 2600.0);
      models.shapes.push_back(make_contact_shape(mesh, stone.mass, stone.name, {0.003, 0.015, 0.005}));
      catalogue.stones.push_back(std::move(stone));
    }
    models.catalogue = &catalogue;
    models.robot = &robot;
    memory = make_memory(options);
    const auto estimate = [](StoneIndex stone, double x, double z) {
      const Pose T_W_O = make_pose(Eigen::Vector3d(x, 0.0, z));
      return StoneEstimate{stone, T_W_O, T_W_O};
    };
    seen.stack = {estimate(0_stone, 0.0, 0.02), estimate(1_stone, 0.0, 0.06)};
    seen.loose = {estimate(2_stone, 0.3, 0.015)};
    memory.attempt.emplace();
    memory.attempt->placement.stone = 2_stone;
    memory.attempt->placement.T_W_O = make_pose(Eigen::Vector3d(0.0, 0.0, 0.095));
    memory.attempt->action = Place{{memory.attempt->placement}};
    memory.attempt->done.status = ExecutionResult::Status::kReleased;
    memory.attempt->below = at_rest(seen).stack;
    memory.attempt->expected_stack = seen.stack;
  }
};

TEST(LearnFromFall, FrictionsAtWhichTheStackCouldNotHaveStoodAreNotLikelier) {
  SlopeScene scene;
  const FrictionEstimate before = scene.memory.friction;
  ASSERT_LT(before.frictions.front(), SlopeScene::kSlope);
  const RunMemory after = learn(scene.memory, scene.seen, scene.models, scene.options, {});
  ASSERT_EQ(after.records.back().outcome, PlacementRecord::Outcome::kFallen);
  const auto& weights = after.friction.weights;
  const double of_standing = weights[1] / before.weights[1];
  EXPECT_NEAR(weights[0] / before.weights[0], of_standing, 0.05 * of_standing)
      << "neither with the lowest friction was it meant to fall";
}

}  // namespace
}  // namespace stonestack::stacking
