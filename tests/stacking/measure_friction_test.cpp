#include "stacking/measure_friction.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stacking/scripted_cell.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"

namespace stonestack::stacking {
namespace {

using scripted::Bench;
using Status = MotionResult::Status;

TEST(FrictionOfDrag, IsHalfTheDifferenceOfBothDirections) {
  EXPECT_NEAR(*friction_of_drag({0.42, 0.44}, {-0.36, -0.38}), 0.40, 1e-12) << "a slope of 0.03 cancels";
  EXPECT_FALSE(friction_of_drag({0.4}, {}));
  EXPECT_FALSE(friction_of_drag({}, {-0.4}));
  EXPECT_FALSE(friction_of_drag({0.1, 0.4}, {-0.4, -0.4})) << "it sticks";
  EXPECT_FALSE(friction_of_drag({-0.1, -0.1}, {0.1, 0.1})) << "no friction pushes";
}

/// A table that presses with 6 N along its normal, on which a dragged stone slides.
struct SlidingBench : Bench {
  double friction = 0.3, slope = 0.0, press = 6.0;
  double along = 0.0;  ///< drag so far [m]

  SlidingBench() {
    arm.after_motion = [this] { answer(); };
  }
  void answer() {
    if (arm.commands.back() == "descend") return push(0.0);
    if (arm.followed.q.empty()) return;
    const Pose T_R_T = forward(scene.robot, arm.q) * scene.T_F_T;
    const Pose T_R_T_now = forward(scene.robot, arm.followed.q.back()) * scene.T_F_T;
    const Eigen::Matrix3d R_W_R = layout.T_W_R.linear();
    Eigen::Vector3d n_W = (R_W_R * T_R_T.linear()).col(0);
    n_W.z() = 0.0;
    const double to = (R_W_R * (T_R_T_now.translation() - T_R_T.translation())).dot(n_W.normalized());
    push(to > along ? 1.0 : -1.0);
    along = to;
  }
  /// `direction` of the drag along the tool's x axis; 0: none.
  void push(double direction) {
    const Eigen::Matrix3d R_W_F = layout.T_W_R.linear() * forward(scene.robot, arm.q).linear();
    Eigen::Vector3d n_W = R_W_F * scene.T_F_T.linear().col(0);
    n_W.z() = 0.0;
    n_W.normalize();
    force.wrench.force =
        R_W_F.transpose() * (press * (Eigen::Vector3d::UnitZ() - (friction * direction + slope) * n_W));
  }
  ExecutionResult drag() {
    arm.guarded = {Status::kNoContact, Status::kContact};
    return execute(plan, stone, scene, cell, {}, nullptr, true);
  }
};

TEST(MeasureFriction, ComparesForcesAlongAndAgainstTheTable) {
  for (const double friction : {0.12, 0.3, 0.6}) {
    SlidingBench bench;
    bench.friction = friction;
    bench.slope = 0.02;
    const ExecutionResult done = bench.drag();
    EXPECT_EQ(done.status, ExecutionResult::Status::kReleased);
    ASSERT_TRUE(done.friction);
    EXPECT_NEAR(*done.friction, friction, 0.01);
    EXPECT_NEAR(bench.along, 0.0, 1e-4) << "the stone is released where it touched";
  }
}

TEST(MeasureFriction, AStoneThatDoesNotPressHasNoFriction) {
  SlidingBench bench;
  bench.press = 0.5;
  const ExecutionResult done = bench.drag();
  EXPECT_EQ(done.status, ExecutionResult::Status::kReleased);
  EXPECT_FALSE(done.friction);
}

TEST(MeasureFriction, AStopOfTheArmEndsIt) {
  SlidingBench bench;
  bench.arm.stops_after = 2;  // the approach, and one drag
  const ExecutionResult done = bench.drag();
  EXPECT_EQ(done.status, ExecutionResult::Status::kStopped);
  EXPECT_THAT(done.reason, testing::HasSubstr("drag"));
}

TEST(MeasureFriction, ARunMeasuresItBeforeAStoneIsStacked) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  for (const double truth : {0.15, 0.5}) {
    simulation::SimulationOptions world_options;
    world_options.seed = 3;
    world_options.friction = truth;
    world_options.friction_spread = 0.0;
    simulation::SimulatedCell world(catalogue.stones, {0, 1, 2}, robot, CellLayout{}, world_options);
    BuildOptions options;
    options.search.horizon = 1;
    options.max_stones = 1;
    Cell cell = world.cell();
    const RunResult run = build_tower(cell, catalogue, robot, options);
    const auto measured = all_of<FrictionMeasured>(run.events);
    ASSERT_EQ(measured.size(), 1U) << truth;
    EXPECT_NEAR(measured.front().friction, truth, 0.07);
    options.measure_friction = false;
    simulation::SimulatedCell again(catalogue.stones, {0, 1, 2}, robot, CellLayout{}, world_options);
    Cell without = again.cell();
    EXPECT_TRUE(all_of<FrictionMeasured>(build_tower(without, catalogue, robot, options).events).empty());
  }
}

}  // namespace
}  // namespace stonestack::stacking
