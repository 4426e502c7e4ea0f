// The table as a lab would measure it: with rays from above, with a stone, and with the gripper.
#include "simulation/true_table.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>

#include "cell_bench.hpp"
#include "geometry/depth_render.hpp"
#include "simulation/gripper_body.hpp"
#include "simulation/true_view.hpp"

namespace stonestack::simulation {
namespace {

using Status = MotionResult::Status;

SimulationOptions with_table() {
  SimulationOptions options;
  options.table_height = 0.002;
  options.table_tilt = 0.00523599;
  options.table_unevenness = 0.0005;
  return options;
}

struct Plane {
  double height = 0.0, tilt = 0.0, largest = 0.0;  // m at the middle, rad, m beside it
};

/// Plane through what rays from above hit on a square of 0.8 m about `centre`.
Plane measure(const TrueTable& table, const Eigen::Vector2d& centre) {
  RayScene scene;
  scene.add(table.surface(), Pose::Identity());
  scene.commit();
  constexpr int kSide = 25;
  Eigen::MatrixXd A(kSide * kSide, 3);
  Eigen::VectorXd z(kSide * kSide);
  for (int i = 0; i < kSide * kSide; ++i) {
    const Eigen::Vector2d p(0.8 * (i % kSide / (kSide - 1.0) - 0.5), 0.8 * (i / kSide / (kSide - 1.0) - 0.5));
    const RayHit hit = scene.cast({centre.x() + p.x(), centre.y() + p.y(), 1.0}, -Eigen::Vector3d::UnitZ());
    A.row(i) << p.x(), p.y(), 1.0;
    z[i] = 1.0 - hit.distance;
    EXPECT_NEAR(z[i], table.height(centre.x() + p.x(), centre.y() + p.y()), 1e-6);
  }
  const Eigen::Vector3d plane = A.colPivHouseholderQr().solve(z);
  return {plane[2], std::atan(plane.head<2>().norm()), (z - A * plane).cwiseAbs().maxCoeff()};
}

TEST(TrueTable, IsTheStatedPlaneWithoutErrors) {
  const TrueTable table;
  EXPECT_EQ(table.height(0.3, -0.4), 0.0);
  EXPECT_EQ(table.shape(), nullptr);
  EXPECT_EQ(TrueTable({}, {0.7, 0.0}).shape(), nullptr);
}

TEST(TrueTable, IsOffTiltedAndUnevenAsStatedByRays) {
  const Eigen::Vector2d centre(0.7, 0.05);
  double highest = -1.0, lowest = 1.0;
  for (int seed = 1; seed <= 10; ++seed) {
    SimulationOptions options = with_table();
    options.seed = seed;
    const TrueTable table(options, centre);
    EXPECT_TRUE(is_closed(table.shape()->scan));
    const Plane plane = measure(table, centre);
    EXPECT_NEAR(std::abs(plane.height), 0.002, 0.0005) << seed;
    EXPECT_NEAR(plane.tilt, 0.00523599, 0.0015) << seed;
    EXPECT_GT(plane.largest, 0.0001) << seed;
    EXPECT_LT(plane.largest, 0.0008) << seed;
    highest = std::max(highest, plane.height);
    lowest = std::min(lowest, plane.height);
  }
  EXPECT_GT(highest, 0.001);
  EXPECT_LT(lowest, -0.001);
}

TEST(TrueTable, OnlyTiltedItIsAPlane) {
  SimulationOptions options;
  options.table_tilt = 0.02;
  const Plane plane = measure(TrueTable(options, {0.7, 0.0}), {0.7, 0.0});
  EXPECT_NEAR(plane.height, 0.0, 1e-9);
  EXPECT_NEAR(plane.tilt, 0.02, 1e-6);
  EXPECT_LT(plane.largest, 1e-6);
}

Stone make_block() {
  Stone stone;
  stone.name = "block";
  stone.scan = stone.mesh = make_box({0.10, 0.08, 0.05});
  stone.mass = mass_properties(stone.scan, 2600);
  return stone;
}

TEST(TrueTable, AStoneRestsOnItAndTouchesIt) {
  SimulationOptions options = with_table();
  options.table_tilt = 0.02;
  options.com_error = options.mass_error = 0.0;
  const Eigen::Vector2d centre(0.7, 0.05);
  TrueWorld world({make_block()}, {0_stone}, make_robotiq_3f(), options, {TrueTable(options, centre), 0});
  GripperPose away;
  away.T_W_T = make_pose(Eigen::Vector3d(0, 0, 10));
  world.set_gripper_pose(away);
  world.place(0_stone, make_pose(Eigen::Vector3d(0.7, 0.05, 0.035)));
  (void)world.wait(6.0);
  EXPECT_TRUE(world.rests(0_stone));
  const Pose& T_W_O = world.pose(0_stone);
  EXPECT_NEAR(T_W_O.translation().z() - 0.025, world.table().height(T_W_O.translation()), 0.0005);
  EXPECT_NEAR(std::acos(T_W_O.linear()(2, 2)), 0.02, 0.006) << "it lies as the table is tilted";
  const auto contacts = world.contacts();
  ASSERT_GE(contacts.size(), 3u);
  for (const auto& contact : contacts) {
    EXPECT_EQ(contact.below, kTable);
    EXPECT_EQ(contact.above, 0);
    EXPECT_GT(contact.n_W.z(), 0.99) << "from the table to the stone";
  }
  const auto judge = world.judge_world(0.001, 200);
  for (int step = 0; step < 2000; ++step) judge->step(0.001);
  EXPECT_LT((judge->pose(0).translation() - T_W_O.translation()).norm(), 0.0005) << "and stays in a verdict";
}

TEST(TrueTable, AStoneThatRollsOverTheEdgeIsGone) {
  SimulationOptions options = with_table();
  TrueWorld world({make_block()}, {0_stone}, make_robotiq_3f(), options, {TrueTable(options, {0.0, 0.0}), 0});
  GripperPose away;
  away.T_W_T = make_pose(Eigen::Vector3d(0, 0, 10));
  world.set_gripper_pose(away);
  world.place(0_stone, make_pose(Eigen::Vector3d(1.6, 0, 0.1)));
  (void)world.wait(4.0);
  EXPECT_GT(world.centre_of_mass(0_stone).norm(), 10.0);
}

TEST(TrueTable, AnUprightGripperMeetsASlopeUphill) {
  const GripperBody body = make_gripper_body(make_robotiq_3f(), "parallel");
  GripperPose upright{tool_down({0.7, 0.0, 0.1}), {}};
  upright.finger.fill(0.0775);
  for (const double slope : {0.02, -0.02}) {
    const auto ground = [slope](const Eigen::Vector3d& p_W) { return slope * (p_W.x() - 0.7); };
    const Eigen::Vector3d corner = lowest_corner(body, upright, ground);
    EXPECT_GT((corner.x() - 0.7) * slope, 0.02 * 0.07) << "a finger's width to the side that is higher";
    EXPECT_NEAR(corner.z(), 0.1, 0.001);
  }
}

TEST(TrueTable, TheGripperFeelsItWhereItIs) {
  for (int seed = 1; seed <= 3; ++seed) {
    SimulationOptions options = with_table();
    options.seed = seed;
    options.arm_repeatability = options.arm_residual = 0.0;
    CellBench bench({make_pebble("pebble", 1.2)}, options);
    ASSERT_EQ(bench.go(tool_down({0.7, 0.3, 0.02})).status, Status::kDone);
    const auto contact = bench.cell.arm.follow_guarded({bench.line(tool_down({0.7, 0.3, -0.02}), 0.005)});
    EXPECT_EQ(contact.status, Status::kContact);
    const double lowest = bench.T_W_T(contact.q).translation().z();
    EXPECT_NEAR(lowest, bench.simulated.world().table().height(0.7, 0.3), 0.001) << seed;
  }
}

}  // namespace
}  // namespace stonestack::simulation
