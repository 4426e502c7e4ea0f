#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"

/// Actions of the loop when a stone falls out of the gripper while it is carried.
namespace stonestack::stacking {
namespace {

using namespace simulation;  // the cell that the loop works in here

/// Loses the first stone that it has lifted, as soon as it moves on with it.
class LosingArm : public Arm {
 public:
  /// The stone then lies `away` (m, level) from where it was grasped.
  LosingArm(const Cell& cell, SimulatedCell& world, const Eigen::Vector2d& away)
      : arm_(cell.arm), world_(world), away_(away), before_(world.truth()) {}

  [[nodiscard]] ArmState state() override { return arm_.state(); }
  [[nodiscard]] MotionResult follow(const JointTrajectory& trajectory) override {
    const Truth truth = world_.truth();
    for (std::size_t k = 0; lost_ == kNoStone && k < truth.T_W_O.size(); ++k) {
      Pose T_W_O = before_.T_W_O[k];
      if (truth.T_W_O[k].translation().z() - T_W_O.translation().z() < kLifted) continue;
      T_W_O.translation().head<2>() += away_;
      lost_ = StoneIndex(k);
      world_.place(lost_, T_W_O);
    }
    return arm_.follow(trajectory);
  }
  [[nodiscard]] MotionResult follow_guarded(const GuardedMotion& motion) override {
    bool carries = false;
    const Truth truth = world_.truth();
    for (std::size_t k = 0; k < truth.T_W_O.size(); ++k)
      carries = carries || truth.T_W_O[k].translation().z() - before_.T_W_O[k].translation().z() > 0.005;
    const Eigen::Vector2d at =
        (layout_.T_W_R * forward(robot_, motion.trajectory.q.back()) * layout_.T_F_T).translation().head<2>();
    const bool descends = motion.n_W_direction.z() < -0.5 &&  // not along the table, to measure the friction,
                          (at - layout_.site).norm() < kAtSite;  // nor to a grasp
    lowered_empty_ += descends && !carries ? 1 : 0;
    return arm_.follow_guarded(motion);
  }
  void stop() override { arm_.stop(); }
  void set_payload(double mass, const Eigen::Vector3d& p_F_com) override { arm_.set_payload(mass, p_F_com); }

  /// Guarded descents with nothing in the gripper.
  [[nodiscard]] int lowered_empty() const { return lowered_empty_; }
  [[nodiscard]] StoneIndex lost() const { return lost_; }

 private:
  static constexpr double kLifted = 0.03, kAtSite = 0.15;  // m
  const RobotModel robot_ = read_robot("ur10");
  const CellLayout layout_;
  Arm& arm_;
  SimulatedCell& world_;
  Eigen::Vector2d away_;
  Truth before_;
  StoneIndex lost_ = kNoStone;
  int lowered_empty_ = 0;
};

/// A run with those stones and that arm.
struct LosingRun {
  Catalogue catalogue = read_catalogue(data_path("stones"));
  RobotModel robot = read_robot("ur10");
  RunResult result;
  StoneIndex lost = kNoStone;
  int lowered_empty = 0, viewed_beside = 0, viewed_pick = 0;

  LosingRun(const std::vector<StoneIndex>& stones, const Eigen::Vector2d& away) {
    SimulationOptions world_options;
    world_options.seed = 7;
    SimulatedCell world(catalogue.stones, stones, robot, CellLayout{}, world_options);
    const Cell devices = world.cell();
    LosingArm arm(devices, world, away);
    Cell cell{arm, devices.gripper, devices.force_torque, devices.camera, devices.clock, devices.layout};
    BuildOptions options;
    options.search.horizon = 1;
    result = build_tower(cell, catalogue, robot, options);
    for (const StoneSought& sought : all_of<StoneSought>(result.events))
      ++(sought.view.where == LookAgain::Where::kBesideSite ? viewed_beside : viewed_pick);
    lost = arm.lost();
    lowered_empty = arm.lowered_empty();
  }
};

TEST(LostOnTheRoute, IsFoundAgainAndPlaced) {
  const LosingRun run({1_stone}, {0.0, 0.0});
  ASSERT_EQ(run.lost, 1_stone);
  EXPECT_EQ(run.lowered_empty, 0);
  ASSERT_EQ(run.result.placements.size(), 2U) << run.result.ended;
  EXPECT_EQ(run.result.placements[0].outcome, PlacementRecord::Outcome::kDropped);
  EXPECT_THAT(run.result.placements[0].note, testing::HasSubstr("it lies on the table"));
  EXPECT_EQ(run.result.placements[1].outcome, PlacementRecord::Outcome::kPlaced);
  EXPECT_EQ(run.result.height, 1) << run.result.ended;
}

TEST(LostOnTheRoute, OutOfSightItIsDoneWithout) {
  const LosingRun run({1_stone, 2_stone}, {-3.0, 0.0});
  ASSERT_NE(run.lost, kNoStone);
  EXPECT_EQ(run.lowered_empty, 0);
  ASSERT_EQ(run.result.placements.size(), 2U) << run.result.ended;
  EXPECT_EQ(run.result.placements[0].outcome, PlacementRecord::Outcome::kDropped);
  EXPECT_EQ(run.result.placements[1].outcome, PlacementRecord::Outcome::kPlaced);
  EXPECT_EQ(run.result.height, 1);
  EXPECT_LE(run.viewed_beside, 4) << "around the site once, not again after the other stone";
  EXPECT_EQ(run.viewed_pick, 1) << "where it was, once, too";
  EXPECT_EQ(run.result.end, RunResult::End::kAllPlaced);
  EXPECT_THAT(run.result.ended, testing::HasSubstr(run.catalogue[run.lost].name + " is out of sight"));
}

}  // namespace
}  // namespace stonestack::stacking
