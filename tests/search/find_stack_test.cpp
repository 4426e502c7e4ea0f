#include "search/find_stack.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "box_scenes.hpp"
#include "physics/shape.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::search {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<StoneIndex> stones(const std::vector<PlacedStone>& placed) {
  std::vector<StoneIndex> list;
  for (const PlacedStone& stone : placed) list.push_back(stone.stone);
  return list;
}

/// The three boxes twice: 0, 1, 2 and 3, 4, 5 are base, middle and top.
const ShapeList& six() {
  static const ShapeList list = [] {
    ShapeList twice = boxes();
    twice.insert(twice.end(), boxes().begin(), boxes().end());
    return twice;
  }();
  return list;
}

TEST(FindStack, FindsTheHighestTowerAnywhere) {
  // Measured a little off: the upper stones 3 mm in the air, the lowest 2 mm in the table.
  const std::vector<PlacedStone> seen{{2_stone, at(1.0, 2.0, 0.133)},  {4_stone, at(-0.3, 0.1, 0.086)},
                                      {0_stone, at(1.0, 2.0, 0.028)},  {1_stone, at(1.01, 2.0, 0.087)},
                                      {3_stone, at(-0.3, 0.1, 0.030)}, {5_stone, at(0.2, 0.2, 0.020)}};
  const SortedStones sorted = find_stack(six(), seen);
  EXPECT_THAT(stones(sorted.stack), ElementsAre(0_stone, 1_stone, 2_stone));
  EXPECT_THAT(stones(sorted.available), ElementsAre(4_stone, 5_stone));
  EXPECT_THAT(stones(sorted.carrying), ElementsAre(3_stone)) << "what carries another is not free";
  EXPECT_THAT(sorted.unsupported, IsEmpty());
}

TEST(FindStack, StonesSideBySideAreNoTower) {
  const std::vector<PlacedStone> seen{
      {0_stone, at(0, 0, 0.03)}, {1_stone, at(0.111, 0, 0.025)}, {2_stone, at(0, 0.2, 0.02)}};
  const SortedStones sorted = find_stack(six(), seen);
  EXPECT_THAT(sorted.stack, IsEmpty());
  EXPECT_THAT(stones(sorted.available), ElementsAre(0_stone, 1_stone, 2_stone));
}

TEST(FindStack, AtASiteOneStoneIsATower) {
  const std::vector<PlacedStone> seen{{0_stone, at(0, 0, 0.03)},
                                      {1_stone, at(0.5, 0, 0.025)},
                                      {3_stone, at(1, 0, 0.03)},
                                      {4_stone, at(1, 0, 0.085)}};
  EXPECT_THAT(stones(find_stack(six(), seen, Eigen::Vector2d(0.5, 0.1)).stack), ElementsAre(1_stone));
  EXPECT_THAT(stones(find_stack(six(), seen, Eigen::Vector2d(1.0, 0.1)).stack),
              ElementsAre(3_stone, 4_stone));
  const SortedStones nowhere = find_stack(six(), seen, Eigen::Vector2d(0.5, 0.2));
  EXPECT_THAT(nowhere.stack, IsEmpty());
  EXPECT_THAT(stones(nowhere.carrying), ElementsAre(3_stone));
}

TEST(FindStack, TwoStonesOnOneAreNoTower) {
  const std::vector<PlacedStone> seen{{0_stone, at(0, 0, 0.03)},
                                      {2_stone, at(-0.045, 0, 0.08)},
                                      {5_stone, at(0.045, 0, 0.08)},
                                      {1_stone, at(0.5, 0, 0.025)}};
  const SortedStones sorted = find_stack(six(), seen);
  EXPECT_THAT(sorted.stack, IsEmpty());
  EXPECT_THAT(stones(sorted.carrying), ElementsAre(0_stone));
  EXPECT_NE(find_stack(six(), seen, Eigen::Vector2d(0, 0)).note, "");
}

TEST(FindStack, AStoneInTheAirIsNeitherLooseNorStacked) {
  const std::vector<PlacedStone> seen{{0_stone, at(0, 0, 0.03)}, {1_stone, at(0.4, 0, 0.085)}};
  const SortedStones sorted = find_stack(six(), seen);
  EXPECT_THAT(stones(sorted.available), ElementsAre(0_stone));
  EXPECT_THAT(stones(sorted.unsupported), ElementsAre(1_stone)) << "what it lies on was not found";
  EXPECT_THAT(sorted.note, HasSubstr("middle lies 60 mm above the table")) << "it is no empty table";
  EXPECT_NE(find_stack(six(), seen, Eigen::Vector2d(0.4, 0.1)).note, "") << "the tower at that site";
  EXPECT_EQ(find_stack(six(), seen, Eigen::Vector2d(0.0, 0.05)).note, "") << "another site";
}

/// Surface of a level face, a point in each square of 5 mm.
std::vector<Eigen::Vector3d> face(double x, double y, double z, double side) {
  std::vector<Eigen::Vector3d> points;
  for (double u = -0.5 * side; u < 0.5 * side; u += 0.005)
    for (double v = -0.5 * side; v < 0.5 * side; v += 0.005) points.emplace_back(x + u, y + v, z);
  return points;
}

std::vector<Eigen::Vector3d> together(std::vector<Eigen::Vector3d> a, const std::vector<Eigen::Vector3d>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(FindStack, SurfaceOfTheStonesThatWereFoundIsExplained) {
  // Seen 4 mm off, and a speck of 4 cm2 beside it.
  const auto seen_W = together(face(0.002, 0, 0.064, 0.10), face(0.3, 0, 0.05, 0.02));
  const SortedStones sorted = find_stack(six(), {{0_stone, at(0, 0, 0.03)}}, std::nullopt, seen_W);
  EXPECT_THAT(sorted.unknown, IsEmpty());
  EXPECT_EQ(sorted.note, "");
  EXPECT_THAT(stones(sorted.available), ElementsAre(0_stone));
}

TEST(FindStack, AnUnknownThingOnAStoneIsPartOfATower) {
  const std::vector<PlacedStone> seen{{2_stone, at(0.5, 0, 0.02)}, {0_stone, at(0, 0, 0.03)}};
  const auto seen_W = together(face(0, 0, 0.11, 0.08), face(0.5, 0, 0.04, 0.06));
  const SortedStones sorted = find_stack(six(), seen, std::nullopt, seen_W);
  ASSERT_EQ(sorted.unknown.size(), 1U);
  EXPECT_EQ(sorted.unknown.front().on, 1) << "over the base";
  EXPECT_NEAR(sorted.unknown.front().highest, 0.11, 1e-6);
  EXPECT_THAT(sorted.note, HasSubstr("something on base"));
  EXPECT_THAT(stones(sorted.available), ElementsAre(2_stone));
  EXPECT_THAT(stones(sorted.carrying), ElementsAre(0_stone)) << "it is not free";
  EXPECT_NE(find_stack(six(), seen, Eigen::Vector2d(0, 0), seen_W).note, "") << "no tower to build on";
  EXPECT_EQ(find_stack(six(), seen, Eigen::Vector2d(0.5, 0), seen_W).note, "") << "another site";
}

TEST(FindStack, AnUnknownThingOnTheTableMayBeATower) {
  const std::vector<PlacedStone> seen{{0_stone, at(0, 0, 0.03)}};
  const SortedStones sorted = find_stack(six(), seen, std::nullopt, face(0.3, 0.2, 0.12, 0.08));
  ASSERT_EQ(sorted.unknown.size(), 1U);
  EXPECT_EQ(sorted.unknown.front().on, -1);
  EXPECT_LT((sorted.unknown.front().p_W - Eigen::Vector2d(0.3, 0.2)).norm(), 0.005);
  EXPECT_THAT(sorted.note, HasSubstr("120 mm high, was not recognised"));
  EXPECT_THAT(stones(sorted.available), ElementsAre(0_stone));
}

TEST(FindStack, RefusesStonesWithoutAShape) {
  EXPECT_THROW((void)find_stack(six(), {{6_stone, Pose::Identity()}}), InvalidArgument);
  EXPECT_THROW((void)find_stack(ShapeList(1), {{0_stone, Pose::Identity()}}), InvalidArgument);
}

/// Cells of 2 cm over a square table of 0.8 m about (1, 1).
std::vector<Eigen::Vector2d> square_table() {
  std::vector<Eigen::Vector2d> cells;
  for (int i = 0; i < 40; ++i)
    for (int k = 0; k < 40; ++k) cells.emplace_back(0.61 + 0.02 * i, 0.61 + 0.02 * k);
  return cells;
}

TEST(ChooseSite, TakesTheMiddleOfWhatIsSeenIfItIsFree) {
  const Eigen::Vector2d middle(1.0, 1.0);
  const std::vector<PlacedStone> aside{{0_stone, at(1.3, 1.3, 0.03)}};
  const auto site = choose_site(six(), aside, aside, square_table(), 0.02, middle);
  ASSERT_TRUE(site);
  EXPECT_LT((*site - middle).norm(), 0.02);
}

TEST(ChooseSite, StaysClearOfLooseStonesAndInView) {
  const Eigen::Vector2d middle(1.0, 1.0);
  const std::vector<PlacedStone> there{{0_stone, at(1.0, 1.0, 0.03)}, {1_stone, at(1.0, 1.2, 0.025)}};
  const auto site = choose_site(six(), there, there, square_table(), 0.02, middle);
  ASSERT_TRUE(site);
  const double radius = six()[0]->radius;
  // Half of the base is 6 cm; the widest stone and a finger's 3 cm go beside it.
  const Eigen::Array2d from_edge = (*site - middle).array().abs() - Eigen::Array2d(0.06, 0.055);
  EXPECT_GT(from_edge.max(0.0).matrix().norm(), radius + 0.03 - 0.01);
  EXPECT_LT((*site - middle).norm(), 0.06 + radius + 0.03 + 0.04)
      << "no further from the middle than it must";
  EXPECT_LT((*site - middle).cwiseAbs().maxCoeff(), 0.4 - 0.5 * radius);
}

TEST(ChooseSite, IsEmptyWhereNothingIsFree) {
  std::vector<PlacedStone> everywhere;
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 4; ++k) everywhere.push_back({0_stone, at(0.7 + 0.2 * i, 0.7 + 0.2 * k, 0.03)});
  EXPECT_FALSE(choose_site(six(), everywhere, {{0_stone, at(0, 0, 0.03)}}, square_table(), 0.02, {1.0, 1.0}));
  EXPECT_FALSE(choose_site(six(), {}, {{0_stone, at(0, 0, 0.03)}}, {}, 0.02, {1.0, 1.0}))
      << "no table in view";
}

}  // namespace
}  // namespace stonestack::search
