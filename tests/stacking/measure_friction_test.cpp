#include "stacking/measure_friction.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

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

/// A table that presses with 6 N, on which a dragged stone slides; when the arm stops, half of the friction
/// relaxes.
struct SlidingBench : Bench {
  double friction = 0.3, slope = 0.0, press = 6.0;
  double along = 0.0;  ///< drag so far [m]

  SlidingBench() {
    arm.after_motion = [this] {
      if (arm.commands.back() == "descend") push(0.0);
    };
    arm.mean_force = [this](const GuardedMotion& motion) { return slide(motion); };
  }
  [[nodiscard]] Eigen::Matrix3d R_W_F() const {
    return layout.T_W_R.linear() * forward(scene.robot, arm.q).linear();
  }
  [[nodiscard]] Eigen::Vector3d n_W_drag() const {
    Eigen::Vector3d n_W = R_W_F() * scene.T_F_T.linear().col(0);
    n_W.z() = 0.0;
    return n_W.normalized();
  }
  /// Of the table on the stone, which slides with `share` of the friction along the drag.
  [[nodiscard]] Eigen::Vector3d f_W(double share) const {
    return press * (Eigen::Vector3d::UnitZ() - (friction * share + slope) * n_W_drag());
  }
  void push(double share) { force.wrench.force = R_W_F().transpose() * f_W(share); }
  double slide(const GuardedMotion& motion) {
    if (std::abs(motion.n_W_direction.z()) > 0.5) return 0.0;
    const double direction = motion.n_W_direction.dot(n_W_drag());
    const Pose T_R_T = forward(scene.robot, arm.q) * scene.T_F_T;
    const Pose T_R_T_end = forward(scene.robot, motion.trajectory.q.back()) * scene.T_F_T;
    along = (layout.T_W_R.linear() * (T_R_T_end.translation() - T_R_T.translation())).dot(n_W_drag());
    const Eigen::Vector3d before = R_W_F() * force.wrench.force;
    push(0.5 * direction);
    return -motion.n_W_direction.dot(f_W(direction) - before);
  }
  ExecutionResult drag() {
    arm.guarded = {Status::kNoContact, Status::kContact};
    arm.guarded.insert(arm.guarded.end(), 4, Status::kNoContact);
    return execute(plan, stone, scene, cell, {}, nullptr, LetGo::kDragged);
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
  bench.arm.guarded = {Status::kNoContact, Status::kContact, Status::kNoContact, Status::kStopped};
  const ExecutionResult done =
      execute(bench.plan, bench.stone, bench.scene, bench.cell, {}, nullptr, LetGo::kDragged);
  EXPECT_EQ(done.status, ExecutionResult::Status::kStopped);
  EXPECT_THAT(done.reason, testing::HasSubstr("dragging"));
}

TEST(MeasureFriction, AStoneThatIsStoppedIsReleasedWithoutAFriction) {
  SlidingBench bench;
  bench.arm.guarded = {Status::kNoContact, Status::kContact, Status::kNoContact, Status::kContact};
  const ExecutionResult done =
      execute(bench.plan, bench.stone, bench.scene, bench.cell, {}, nullptr, LetGo::kDragged);
  EXPECT_EQ(done.status, ExecutionResult::Status::kReleased);
  EXPECT_FALSE(done.friction);
}

TEST(MeasureFriction, ARunMeasuresItBeforeAStoneIsStacked) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  for (const double truth : {0.15, 0.5}) {
    simulation::SimulationOptions world_options;
    world_options.seed = 3;
    world_options.friction = truth;
    world_options.friction_spread = 0.0;
    simulation::SimulatedCell world(catalogue.stones, first_stones(3), robot, CellLayout{}, world_options);
    BuildOptions options;
    options.search.horizon = 1;
    options.max_stones = 1;
    Cell cell = world.cell();
    const RunResult run = build_tower(cell, catalogue, robot, options);
    const auto measured = all_of<FrictionMeasured>(run.events);
    ASSERT_EQ(measured.size(), 1U) << truth;
    EXPECT_NEAR(measured.front().friction, truth, 0.07);
    options.measure_friction = false;
    simulation::SimulatedCell again(catalogue.stones, first_stones(3), robot, CellLayout{}, world_options);
    Cell without = again.cell();
    EXPECT_TRUE(all_of<FrictionMeasured>(build_tower(without, catalogue, robot, options).events).empty());
  }
}

}  // namespace
}  // namespace stonestack::stacking
