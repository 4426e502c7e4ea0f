#include "stonestack/experiment/experiment.hpp"

#include <gtest/gtest.h>

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
  CellLayout layout;
  SimulatedCell simulated{three_boxes(), first_stones(3), read_robot("ur10"), layout};
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

TEST(JudgeTower, TriesATowerByWaitingAndShaking) {
  Bench bench;
  const auto site = bench.layout.site;
  bench.simulated.place(0_stone, make_pose(Eigen::Vector3d(site.x(), site.y(), 0.0250)));
  bench.simulated.place(1_stone, make_pose(Eigen::Vector3d(site.x() + 0.01, site.y(), 0.0751)));
  SurvivalOptions options{.seconds = {0.5, 1.0, 2.0}};
  auto left = try_tower(bench.simulated, options);
  EXPECT_EQ(left.standing, (std::vector<int>{2, 2, 2}));
  EXPECT_EQ(left.shaken, 2) << "0.2 g neither tips nor slides a flat box";
  options.shake_acceleration = 15.0;  // far above what friction of at most 0.65 carries
  options.shake_frequency = 1.0;
  options.shake_seconds = 1.5;
  EXPECT_LT(try_tower(bench.simulated, options).shaken, 2);
  bench.simulated.place(2_stone, make_pose(Eigen::Vector3d(site.x() + 0.09, site.y(), 0.1252)));
  left = try_tower(bench.simulated, options);
  EXPECT_EQ(left.standing, (std::vector<int>{2, 2, 2})) << "a box over the edge falls";
}

}  // namespace
}  // namespace stonestack::experiment
