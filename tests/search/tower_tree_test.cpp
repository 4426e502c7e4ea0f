#include "search/tower_tree.hpp"

#include <gtest/gtest.h>

namespace stonestack::search {
namespace {

Trial trial_of(StoneIndex stone, double margin = 0.1, double success = 1.0) {
  Trial trial;
  trial.stone = stone;
  trial.margin = margin;
  trial.placement.stone = stone;
  trial.placement.predicted_success = success;
  return trial;
}

TowerTree four_stones(int levels = 2, bool firm = false) {
  return TowerTree(Stack{},
                   {{0_stone, Pose::Identity()},
                    {1_stone, Pose::Identity()},
                    {2_stone, Pose::Identity()},
                    {3_stone, Pose::Identity()}},
                   levels, firm);
}

TEST(TowerTree, ChildrenStandOnTheirParents) {
  TowerTree tree = four_stones();
  const int first = tree.add(0, trial_of(2_stone), 0.1);
  const int second = tree.add(first, trial_of(0_stone), 0.1);
  EXPECT_EQ(tree.node(second).level, 2);
  ASSERT_EQ(tree.node(second).stack.stones.size(), 2U);
  EXPECT_EQ(tree.node(second).stack.stones[0].stone, 2_stone);
  EXPECT_EQ(tree.node(second).stack.stones[1].stone, 0_stone);
  EXPECT_EQ(tree.node(second).left.size(), 2U);
  EXPECT_EQ(tree.path_to(second), (std::vector<int>{first, second}));
  EXPECT_EQ(tree.children(0), std::vector<int>{first});
  EXPECT_EQ(tree.reach(0), 2);
}

TEST(TowerTree, SistersGiveWay) {
  TowerTree tree = four_stones();
  const int a = tree.add(0, trial_of(0_stone), 0.2), b = tree.add(0, trial_of(1_stone), 0.2);
  const int a1 = tree.add(a, trial_of(2_stone), 0.100), a2 = tree.add(a, trial_of(3_stone), 0.099);
  const int b1 = tree.add(b, trial_of(2_stone), 0.095);
  EXPECT_EQ(tree.choose(2, 3, 0.0), (std::vector<int>{a1, a2, b1}));
  EXPECT_EQ(tree.choose(2, 3, 0.01), (std::vector<int>{a1, b1, a2}));
  EXPECT_EQ(tree.choose(2, 1, 0.01), std::vector<int>{a1});
}

TEST(TowerTree, TheDeadAndTheDoneAreNotChosen) {
  TowerTree tree = four_stones();
  const int a = tree.add(0, trial_of(0_stone), 0.2), b = tree.add(0, trial_of(1_stone), 0.1);
  tree.node(a).trial.alive = false;
  EXPECT_EQ(tree.choose(1, 4, 0.01), std::vector<int>{b});
  tree.set_grown(b);
  EXPECT_TRUE(tree.choose(1, 4, 0.01).empty());
  tree.node(b).spare.emplace_back();
  EXPECT_EQ(tree.choose(1, 4, 0.01), std::vector<int>{b});
}

TEST(TowerTree, ChanceGrowsWithRoutesToFinishAndFallsWithRisk) {
  TowerTree tree = four_stones();
  const int a = tree.add(0, trial_of(0_stone), 0.1), b = tree.add(0, trial_of(1_stone), 0.1);
  for (const int k : {a, b}) {
    tree.node(k).judged = tree.node(k).predicted = true;
    tree.set_grown(k);
  }
  EXPECT_EQ(tree.chance(a, 0.1), 0.0);  // grown, and nothing came of it
  tree.add(a, trial_of(2_stone), 0.1);
  tree.add(b, trial_of(2_stone), 0.1);
  const double one_way = tree.chance(a, 0.1);
  EXPECT_GT(one_way, 0.0);
  tree.add(b, trial_of(3_stone), 0.1);
  EXPECT_GT(tree.chance(b, 0.1), one_way);
  tree.node(b).trial.placement.predicted_success = 0.5;
  EXPECT_LT(tree.chance(b, 0.1), one_way);
}

TEST(TowerTree, AFirmTowerIsTheOneThatOutlastsAShake) {
  for (const bool firm : {false, true}) {
    TowerTree tree = four_stones(2, firm);
    const int a = tree.add(0, trial_of(0_stone), 0.1), b = tree.add(0, trial_of(1_stone), 0.1);
    const int sure = tree.add(a, trial_of(2_stone, 0.1, 1.0), 0.1);
    const int lasting = tree.add(b, trial_of(2_stone, 0.1, 0.9), 0.1);
    for (const int k : {a, b, sure, lasting}) {
      tree.node(k).judged = tree.node(k).predicted = true;
      tree.node(k).trial.tried = 10;
      tree.set_grown(k);
    }
    tree.node(lasting).trial.shaken = 8;
    EXPECT_DOUBLE_EQ(tree.firmness(lasting), 0.8);
    EXPECT_EQ(tree.chance(b, 0.1) > tree.chance(a, 0.1), firm);
    EXPECT_EQ(tree.best_path_from(0), (std::vector<int>{firm ? b : a, firm ? lasting : sure}));
  }
}

TEST(TowerTree, AnUnfinishedTowerIsNoFirmOne) {
  TowerTree tree = four_stones(2, true);
  const int low = tree.add(0, trial_of(0_stone, 0.5), 0.1), b = tree.add(0, trial_of(1_stone), 0.1);
  const int top = tree.add(b, trial_of(2_stone, 0.1, 0.6), 0.1);
  for (const int k : {low, b, top}) {
    tree.node(k).judged = tree.node(k).predicted = true;
    tree.node(k).trial.tried = 10;
  }
  EXPECT_EQ(tree.best_path_from(0), (std::vector<int>{b, top})) << "higher, though it outlasts no shake";
}

TEST(TowerTree, OfEquallyHighRoutesTheFirmerIsBest) {
  TowerTree tree = four_stones();
  const int a = tree.add(0, trial_of(0_stone), 0.1);
  const int weak = tree.add(a, trial_of(1_stone, 0.02), 0.1),
            firm = tree.add(a, trial_of(2_stone, 0.06), 0.1);
  const int likelier = tree.add(a, trial_of(3_stone, 0.02), 0.1);
  tree.node(likelier).trial.placement.predicted_success = 1.0;
  for (const int k : {a, weak, firm, likelier}) {
    tree.node(k).judged = tree.node(k).predicted = true;
    tree.node(k).trial.placement.predicted_success = k == likelier || k == a ? 1.0 : 0.75;
  }
  EXPECT_EQ(tree.best_path_from(a), std::vector<int>{likelier});  // a quarter of a stone more
  tree.node(likelier).trial.placement.predicted_success = 0.75;
  EXPECT_EQ(tree.best_path_from(a), std::vector<int>{firm});
}

TEST(TowerTree, UntriedPosesRankBetweenCertainAndUnstableOnes) {
  TowerTree tree = four_stones();
  const int certain = tree.add(0, trial_of(0_stone), 0.1), untried = tree.add(0, trial_of(1_stone), 0.1);
  const int poor = tree.add(0, trial_of(2_stone, 0.1, 0.6), 0.1);
  for (const int k : {certain, untried, poor}) tree.node(k).judged = true;
  tree.node(certain).predicted = tree.node(poor).predicted = true;
  EXPECT_EQ(tree.best_path_from(0), std::vector<int>{certain});
  tree.node(certain).trial.alive = false;
  EXPECT_EQ(tree.best_path_from(0), std::vector<int>{untried});
}

TEST(TowerTree, ASubtreeIsEverythingAboveANode) {
  TowerTree tree = four_stones();
  const int a = tree.add(0, trial_of(0_stone), 0.1), b = tree.add(0, trial_of(1_stone), 0.1);
  const int a1 = tree.add(a, trial_of(1_stone), 0.1), b1 = tree.add(b, trial_of(0_stone), 0.1);
  const int a12 = tree.add(a1, trial_of(2_stone), 0.1);
  EXPECT_EQ(tree.subtree(a), (std::vector<int>{a1, a12}));
  EXPECT_EQ(tree.subtree(b), std::vector<int>{b1});
  EXPECT_TRUE(tree.subtree(a12).empty());
}

}  // namespace
}  // namespace stonestack::search
