#include "stonestack/experiment/experiment.hpp"

#include <gtest/gtest.h>

#include "physics/bodies.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/experiment/simulated_run.hpp"

namespace stonestack::experiment {
namespace {

std::vector<Stone> three_boxes() {
  std::vector<Stone> stones;
  for (const char* name : {"base", "middle", "top"}) {
    Stone stone;
    stone.name = name;
    stone.scan = stone.mesh = make_box({0.12, 0.10, 0.05});
    stone.mass = mass_properties(stone.scan, 2600);
    stones.push_back(stone);
  }
  return stones;
}

/// A cell with three boxes.
struct Bench {
  std::vector<Stone> stones = three_boxes();
  CellLayout layout = {};
  SimulatedCell simulated{stones, first_stones(3), read_robot("ur10"), layout};
};

TEST(JudgeTower, JudgesATrueTower) {
  // Boxes: two on each other stand; a third half over the edge falls.
  Bench bench;
  const auto site = bench.layout.site;
  const auto put = [&](StoneIndex stone, double dx, double z) {
    bench.simulated.place(stone, make_pose(Eigen::Vector3d(site.x() + dx, site.y(), z)));
  };
  EXPECT_EQ(judge_tower(bench.simulated).stand.standing, 0);
  put(0_stone, 0, 0.0250);
  put(1_stone, 0.01, 0.0751);
  auto verdict = judge_tower(bench.simulated);
  EXPECT_TRUE(verdict.stand.stands) << verdict.stand.reason;
  EXPECT_TRUE(verdict.stand.clean);
  EXPECT_EQ(verdict.stones, (std::vector<StoneIndex>{0_stone, 1_stone}));
  put(2_stone, 0.09, 0.1252);
  verdict = judge_tower(bench.simulated);
  EXPECT_FALSE(verdict.stand.stands);
  EXPECT_EQ(verdict.stand.standing, 2) << verdict.stand.reason;
  // Leaning on the table beside the stone below is not stacked.
  put(2_stone, 0.131, 0.0251);
  put(1_stone, 0.065, 0.0752);
  verdict = judge_tower(bench.simulated);
  EXPECT_FALSE(verdict.stand.clean);
  EXPECT_LE(verdict.stand.standing, 1);
}

/// Both engines, on a tower that stands by analysis and on one that does not.
TEST(JudgeTower, BothEnginesJudge) {
  std::vector<Stone> slabs = three_boxes();
  for (std::size_t k = 0; k < slabs.size(); ++k) {
    slabs[k].scan = slabs[k].mesh = test::rough_slab({0.12, 0.10, 0.05}, k);
    slabs[k].mass = mass_properties(slabs[k].scan, 2600);
  }
  Bench bench{slabs};
  const auto site = bench.layout.site;
  const auto put = [&](StoneIndex stone, double dx, double z) {
    bench.simulated.place(stone, make_pose(Eigen::Vector3d(site.x() + dx, site.y(), z)));
  };
  put(0_stone, 0, 0.0248);
  put(1_stone, 0.01, 0.0742);
  put(2_stone, -0.01, 0.1236);
  bench.simulated.wait(10.0);  // after 2 s the top still creeps by 0.1 mm/s
  RunResult result;
  result.height = 3;
  const TruthReport stands = judge_run(bench.simulated, result);
  ASSERT_EQ(stands.engines.size(), 2u);
  EXPECT_EQ(stands.engines[0].engine, "bullet");
  EXPECT_EQ(stands.engines[1].engine, "ode");
  for (const EngineVerdict& verdict : stands.engines)
    EXPECT_EQ(verdict.height, 3) << verdict.engine << ": " << verdict.note;
  EXPECT_TRUE(stands.stands);
  EXPECT_EQ(stands.height, 3);
  EXPECT_FALSE(engines_disagree(stands));

  put(2_stone, 0.085, 0.1236);  // its centre of mass 15 mm beyond the edge of the one below
  const TruthReport falls = judge_run(bench.simulated, result);
  for (const EngineVerdict& verdict : falls.engines) {
    EXPECT_EQ(verdict.height, 2) << verdict.engine << ": " << verdict.note;
    EXPECT_GT(verdict.shift, 0.02) << verdict.engine;
  }
  EXPECT_FALSE(falls.stands);
  EXPECT_EQ(falls.height, 2);
  EXPECT_THROW((void)judge_tower(bench.simulated, tower_bounds(), "mujoco"), InvalidArgument);
}

TEST(JudgeTower, TriesATowerByWaitingAndShaking) {
  Bench bench;
  const auto site = bench.layout.site;
  bench.simulated.place(0_stone, make_pose(Eigen::Vector3d(site.x(), site.y(), 0.0250)));
  bench.simulated.place(1_stone, make_pose(Eigen::Vector3d(site.x() + 0.01, site.y(), 0.0751)));
  SurvivalOptions options{.seconds = {0.5, 1.0, 2.0}};
  auto left = try_tower(bench.simulated, options);
  EXPECT_EQ(left.standing, (std::vector<int>{2, 2, 2}));
  EXPECT_EQ(left.shaken, 2) << "0.2 g neither tips nor slides a flat box";
  options.shake.acceleration = 15.0;  // far above what friction of at most 0.65 carries
  options.shake.frequency = 1.0;
  options.shake.seconds = 1.5;
  EXPECT_LT(try_tower(bench.simulated, options).shaken, 2);
  bench.simulated.place(2_stone, make_pose(Eigen::Vector3d(site.x() + 0.09, site.y(), 0.1252)));
  left = try_tower(bench.simulated, options);
  EXPECT_EQ(left.standing, (std::vector<int>{2, 2, 2})) << "a box over the edge falls";
}

TEST(JudgeWall, CountsTheStonesThatAreWhereItIsSaidAndStay) {
  Bench bench;
  const auto site = bench.layout.site;
  std::vector<PlacedStone> wall;
  const auto put = [&](StoneIndex stone, double dx, double z) {
    const Pose T_W_O = make_pose(Eigen::Vector3d(site.x() + dx, site.y(), z));
    bench.simulated.place(stone, T_W_O);
    wall.push_back({stone, T_W_O});
  };
  put(0_stone, -0.07, 0.025);
  put(1_stone, 0.07, 0.025);
  put(2_stone, 0.0, 0.0751);
  TowerVerdict verdict = judge_wall(bench.simulated, wall);
  EXPECT_TRUE(verdict.stand.stands) << verdict.stand.reason;
  EXPECT_EQ(verdict.stand.standing, 3);
  SurvivalOptions options{.seconds = {0.5}};
  EXPECT_EQ(try_tower(bench.simulated, options, tower_bounds(), wall).standing, std::vector<int>{3});
  EXPECT_EQ(try_tower(bench.simulated, options, tower_bounds(), wall).shaken, 3);
  RunResult result;
  result.height = 3;
  result.world.stack = stacking::as_estimates(wall);
  EXPECT_LT(judge_run(bench.simulated, result).height, 3) << "it is no tower";
  result.wall = WallMetrics{};
  EXPECT_EQ(judge_run(bench.simulated, result).height, 3);

  bench.simulated.place(2_stone, make_pose(Eigen::Vector3d(site.x() + 0.30, site.y(), 0.025)));
  verdict = judge_wall(bench.simulated, wall);  // the estimate still has it up there
  EXPECT_FALSE(verdict.stand.stands);
  EXPECT_EQ(verdict.stand.standing, 2) << verdict.stand.reason;
}

}  // namespace
}  // namespace stonestack::experiment
