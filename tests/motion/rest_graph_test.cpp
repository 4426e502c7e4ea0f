#include "motion/pick_and_place/rest_graph.hpp"

#include <gtest/gtest.h>

#include "motion/pick_and_place/set_down.hpp"

namespace stonestack::motion {
namespace {

using Chains = std::vector<std::vector<int>>;

/// Poses 0 to 3; 0-1 share two grasps, 1-2 one, 2-3 one, 0-3 none.
RestGraph ladder() {
  return {std::vector<RestPose>(4), {{0, 1, 2}, {1, 2, 3}, {3, 4}, {4, 5}}};
}

TEST(RestGraph, ShortestChainsComeFirst) {
  EXPECT_EQ(rest_chains(ladder(), {0}, {1, 2}, 1), (Chains{{0}}));
  const Chains chains = rest_chains(ladder(), {0, 1}, {3}, 2);
  // 1 is entered by grasp 1 and left by 3; over 0 it takes one more stop, and so does the chain to 2.
  ASSERT_FALSE(chains.empty());
  EXPECT_EQ(chains.front(), (std::vector<int>{1}));
  for (std::size_t i = 1; i < chains.size(); ++i) EXPECT_GE(chains[i].size(), chains[i - 1].size());
}

TEST(RestGraph, AsManyStopsAsAllowed) {
  EXPECT_TRUE(rest_chains(ladder(), {0}, {5}, 3).empty());
  EXPECT_EQ(rest_chains(ladder(), {0}, {5}, 4), (Chains{{0, 1, 2, 3}}));
  EXPECT_TRUE(rest_chains(ladder(), {}, {5}, 4).empty());
  EXPECT_TRUE(rest_chains(ladder(), {0}, {}, 4).empty());
}

TEST(RestGraph, OfEqualLengthTheOneWithMoreGrasps) {
  const RestGraph graph{std::vector<RestPose>(2), {{0, 5}, {0, 1, 5, 6}}};
  EXPECT_EQ(rest_chains(graph, {0, 1}, {5, 6}, 1), (Chains{{1}, {0}}));
}

TEST(RestGraph, CommonNumbersOfTwoLists) {
  EXPECT_EQ(common({1, 3, 5}, {0, 3, 4, 5}), (std::vector<int>{3, 5}));
  EXPECT_TRUE(common({}, {1}).empty());
}

struct Field {
  Stone stone;
  PlanningScene scene;
  PickAndPlaceTask task;
  RegraspOptions options;

  Field() {
    stone.name = "block";
    stone.scan = stone.mesh = make_box({0.10, 0.08, 0.06});
    stone.pieces = {stone.scan};
    stone.mass = mass_properties(stone.scan, 2600.0);
    scene.robot = read_robot("ur10");
    task.stone = &stone;
    task.object = 0;
    task.T_W_O_pick = make_pose({0.7, -0.2, 0.03});
    task.T_W_O_place = make_pose({0.7, 0.0, 0.10});
    scene.objects = {{"block", stone.pieces, task.T_W_O_pick},
                     {"rock", {make_box({0.08, 0.08, 0.08})}, make_pose({0.7, -0.06, 0.04})}};
  }
};

TEST(SetDown, PlacesAreFreeOfEverythingElseNearestFirst) {
  const Field field;
  const auto poses =
      SetDownPlaces(field.scene, field.task, field.options).poses(Eigen::Quaterniond::Identity());
  ASSERT_GT(poses.size(), 100u);
  EXPECT_NEAR((poses.front().translation() - field.task.T_W_O_pick.translation()).norm(), 0.0, 1e-9)
      << "its own place is free";
  double last = 0.0;
  for (const Pose& T_W_O : poses) {
    const double away = (T_W_O.translation() - field.task.T_W_O_pick.translation()).head<2>().norm();
    EXPECT_GE(away, last - 1e-6);
    last = away;
    double lowest = 1.0, nearest = 1.0;
    for (const auto& v : field.stone.scan.vertices) {
      const Eigen::Vector3d p = T_W_O * v;
      lowest = std::min(lowest, p.z());
      const Eigen::Vector2d outside =
          ((p.head<2>() - Eigen::Vector2d(0.7, -0.06)).cwiseAbs() - Eigen::Vector2d(0.04, 0.04))
              .cwiseMax(0.0);
      nearest = std::min(nearest, outside.norm());
    }
    EXPECT_NEAR(lowest, 0.0, 1e-9);
    EXPECT_GE(nearest, field.options.apart - 1e-9);
  }
}

TEST(SetDown, NoPlaceInACrowd) {
  Field field;
  field.scene.objects.push_back({"slab", {make_box({2.0, 2.0, 0.01})}, make_pose({0.7, -0.2, 0.005})});
  EXPECT_TRUE(
      SetDownPlaces(field.scene, field.task, field.options).poses(Eigen::Quaterniond::Identity()).empty());
}

}  // namespace
}  // namespace stonestack::motion
