#include <gtest/gtest.h>

#include "emulators/ur/plant.hpp"
#include "simulation/pebble.hpp"
#include "simulation/shared_world.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::emulators {
namespace {

struct WorldPlantBench {
  std::vector<Stone> stones{make_pebble("pebble", 1.2)};
  RobotModel robot = read_robot("ur10");
  CellLayout layout;
  SimulatedCell cell{stones, {0_stone}, robot, layout};
  SharedWorld& world = cell.shared();
  Joints q = cell.cell().arm.state().q;
};

TEST(WorldPlant, MeasuresTheGrippersWeightAndTheTable) {
  WorldPlantBench bench;
  const auto plant = make_world_plant(bench.world, bench.q);
  PlantState state = plant->step(bench.q, 0.008);
  const double weight = 9.81 * carried_mass(bench.world.lock().world.gripper_body().gripper);
  EXPECT_NEAR(state.force_R.z(), -weight, 1e-6);
  // The gripper points down: its mass hangs under the flange, so there is hardly a moment about the flange.
  EXPECT_LT(state.torque_R.norm(), 0.05 * weight);
  // Shoulder down until something is met: the table, the stone or the arm itself stops it.
  Joints q = bench.q;
  for (int k = 0; k < 2000 && state.hit.empty(); ++k) {
    q[1] += 0.0005;
    state = plant->step(q, 0.008);
  }
  EXPECT_FALSE(state.hit.empty());
  EXPECT_NEAR(state.qd[1], 0.0005 / 0.008, 1e-9);
  EXPECT_LT((state.q - q).norm(), 1e-12);
}

/// The arm behind its protocols does not come back to a place more exactly than the one in process.
TEST(WorldPlant, ComesBackToATenthOfAMillimetre) {
  WorldPlantBench bench;
  const auto plant = make_world_plant(bench.world, bench.q);
  Joints away = bench.q;
  away[0] += 0.02;
  const auto go = [&](const Joints& from, const Joints& to) {
    for (int k = 1; k <= 60; ++k) (void)plant->step(from + std::min(1.0, k / 50.0) * (to - from), 0.02);
  };
  constexpr int kVisits = 100;
  const Joints q_true = bench.q + bench.world.mounting().joint_error;
  const Pose T_W_T = bench.layout.T_W_R * forward(bench.robot, q_true) * bench.layout.T_F_T;
  double squares = 0.0;
  for (int k = 0; k < kVisits; ++k) {
    go(bench.q, away);
    go(away, bench.q);
    const Pose& there = bench.world.lock().world.gripper_pose().T_W_T;
    squares += (there.translation() - T_W_T.translation()).squaredNorm() / kVisits;
  }
  EXPECT_NEAR(std::sqrt(squares), 0.0001, 0.000015);
}

}  // namespace
}  // namespace stonestack::emulators
