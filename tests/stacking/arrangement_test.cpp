#include "stacking/arrangement.hpp"

#include <gtest/gtest.h>

#include "box_shape.hpp"
#include "core/constants.hpp"

namespace stonestack::stacking {
namespace {

/// Four slabs, the lower ones wider; the site is the default one.
const ShapeList& slabs() {
  static const ShapeList list = {box("a", {0.12, 0.12, 0.05}), box("b", {0.10, 0.10, 0.05}),
                                 box("c", {0.08, 0.08, 0.05}), box("d", {0.08, 0.06, 0.05})};
  return list;
}

Pose on_site(double z, double x = 0.0, double yaw = 0.0) {
  const Eigen::Vector2d site = CellLayout{}.site;
  return make_pose({site.x() + x, site.y(), z},
                   Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())));
}

StoneEstimates estimate(const std::vector<PlacedStone>& expected, const std::vector<Sighting>& sightings) {
  return estimate_stones(slabs(), {}, as_estimates(expected), sightings);
}

Sighting seen(StoneIndex stone, const Pose& T_W_O) {
  return {stone, T_W_O, 0.95, 0.5};
}

TEST(EstimateStones, SortsStackAndLooseStones) {
  const std::vector<PlacedStone> expected{{0_stone, on_site(0.025)}, {1_stone, on_site(0.075)}};
  const Pose aside = make_pose({0.7, -0.2, 0.025});
  const StoneEstimates stones =
      estimate(expected,
               {seen(2_stone, aside), seen(1_stone, on_site(0.0755, 0.001)), seen(0_stone, on_site(0.0252))});
  ASSERT_EQ(stones.stack.size(), 2U);
  EXPECT_EQ(stones.stack[1].stone, 1_stone);
  EXPECT_NEAR(stones.stack[1].T_W_O_at_rest.translation().z(), 0.075, 1e-4);  // settled on the stone below
  ASSERT_EQ(stones.loose.size(), 1U);
  EXPECT_EQ(stones.loose[0].stone, 2_stone);
}

TEST(EstimateStones, APartOfTheStackIsNoLooseStone) {
  const std::vector<PlacedStone> expected{{0_stone, on_site(0.025)}, {1_stone, on_site(0.075)}};
  const std::vector<Sighting> stack{seen(0_stone, on_site(0.025)), seen(1_stone, on_site(0.075))};
  for (const Pose& phantom : {on_site(0.04, 0.02), on_site(0.08, 0.03, 1.0), on_site(0.20)}) {
    std::vector<Sighting> all = stack;
    all.push_back(seen(3_stone, phantom));
    EXPECT_TRUE(estimate(expected, all).loose.empty()) << phantom.translation().transpose();
  }
  std::vector<Sighting> all = stack;
  all.push_back(seen(3_stone, on_site(0.025, 0.12)));  // beside the base, touching nothing
  EXPECT_EQ(estimate(expected, all).loose.size(), 1U);
}

TEST(EstimateStones, AStoneThatCarriesAnotherHasNotMoved) {
  const std::vector<PlacedStone> expected{
      {0_stone, on_site(0.025)}, {1_stone, on_site(0.075)}, {2_stone, on_site(0.125)}};
  // The middle one is half hidden and badly seen.
  const StoneEstimates stones =
      estimate(expected, {seen(0_stone, on_site(0.025)), seen(1_stone, on_site(0.078, 0.012, 20 * kDegree)),
                          seen(2_stone, on_site(0.1255))});
  ASSERT_EQ(stones.stack.size(), 3U);
  EXPECT_LT(difference(stones.stack[1].T_W_O_at_rest, expected[1].T_W_O).translation, 1e-9);
}

TEST(EstimateStones, AStoneOnTheTableHasFallen) {
  const std::vector<PlacedStone> expected{{0_stone, on_site(0.025)}, {1_stone, on_site(0.075)}};
  const StoneEstimates stones =
      estimate(expected, {seen(0_stone, on_site(0.025)), seen(1_stone, on_site(0.025, 0.13))});
  EXPECT_EQ(stones.stack.size(), 1U);
  ASSERT_EQ(stones.loose.size(), 1U);
  EXPECT_EQ(stones.loose[0].stone, 1_stone);
}

TEST(EstimateStones, AHiddenStoneStaysWhereItsPlaceIsNotRefuted) {
  const std::vector<PlacedStone> expected{{0_stone, on_site(0.025)}, {1_stone, on_site(0.075)}};
  const auto stones = [&](StoneIndex gone) {
    return estimate_stones(slabs(), {}, as_estimates(expected), {}, {},
                           [=](const PlacedStone& stone) { return stone.stone == gone; });
  };
  EXPECT_TRUE(estimate(expected, {}).stack.empty()) << "nothing says that they are there";
  ASSERT_EQ(stones(1_stone).stack.size(), 1U);
  EXPECT_LT(difference(stones(1_stone).stack[0].T_W_O_at_rest, expected[0].T_W_O).translation, 1e-9);
  EXPECT_TRUE(stones(0_stone).stack.empty()) << "nothing floats";
  EXPECT_EQ(stones(2_stone).stack.size(), 2U);
}

TEST(EstimateStones, StonesOfAWallStandBesideAndOnEachOther) {
  BuildOptions wall;
  wall.wall = "2+1";
  const std::vector<PlacedStone> expected{
      {1_stone, on_site(0.025, -0.055)}, {2_stone, on_site(0.025, 0.055)}, {3_stone, on_site(0.075)}};
  const auto estimated = [&](const std::vector<Sighting>& sightings) {
    return estimate_stones(slabs(), {}, as_estimates(expected), sightings, wall);
  };
  std::vector<Sighting> all{seen(1_stone, on_site(0.025, -0.055)), seen(2_stone, on_site(0.025, 0.056)),
                            seen(3_stone, on_site(0.076, 0.004))};
  ASSERT_EQ(estimated(all).stack.size(), 3U);
  EXPECT_NEAR(estimated(all).stack[2].T_W_O_at_rest.translation().x(), CellLayout{}.site.x() + 0.004, 0.002);
  EXPECT_EQ(estimate(expected, all).stack.size(), 1U) << "no tower";

  all[2] = seen(3_stone, on_site(0.025, 0.30));  // the upper one has fallen
  EXPECT_EQ(estimated(all).stack.size(), 2U);
  ASSERT_EQ(estimated(all).loose.size(), 1U);
  EXPECT_EQ(estimated(all).loose[0].stone, 3_stone);

  all = {seen(2_stone, on_site(0.025, 0.055)), seen(3_stone, on_site(0.075))};  // the first is hidden
  EXPECT_EQ(estimated(all).stack.size(), 3U) << "it carries what is seen";
  all = {seen(2_stone, on_site(0.025, 0.055))};
  EXPECT_EQ(estimated(all).stack.size(), 1U) << "nothing shows that the others are there";
}

TEST(StrayAtStack, NamesTheLowestLevelThatALooseStoneTouches) {
  Arrangement arrangement{{{0_stone, on_site(0.025)}, {1_stone, on_site(0.075)}},
                          {{2_stone, on_site(0.025, 0.112)}}};
  EXPECT_FALSE(stray_at_stack(slabs(), arrangement)) << "12 mm beside the base";
  arrangement.loose.push_back({3_stone, on_site(0.080, 0.0915)});  // 1.5 mm beside the upper slab
  auto stray = stray_at_stack(slabs(), arrangement);
  ASSERT_TRUE(stray);
  EXPECT_EQ(stray->level, 1U);
  EXPECT_EQ(stray->stone.stone, 3_stone);
  arrangement.loose[0].T_W_O = on_site(0.025, 0.1015);
  stray = stray_at_stack(slabs(), arrangement);
  ASSERT_TRUE(stray);
  EXPECT_EQ(stray->level, 0U);
  EXPECT_EQ(stray->stone.stone, 2_stone);
}

TEST(LeansOnLoose, CountsWhatStaysWhereItIs) {
  const PlacedStone placed{1_stone, on_site(0.075)};
  const std::vector<PlacedStone> below{{0_stone, on_site(0.025)}};
  const auto leans = [&](StoneIndex stone, double beside) {
    return leans_on_loose(slabs(), {{stone, on_site(0.080, beside)}}, placed, below);
  };
  EXPECT_TRUE(leans(3_stone, 0.0945)) << "4.5 mm: poses err by more than what is left";
  EXPECT_FALSE(leans(3_stone, 0.100)) << "10 mm";
  EXPECT_FALSE(leans(1_stone, 0.0945)) << "it is the one that is placed";
  EXPECT_FALSE(leans(0_stone, 0.0945)) << "it is placed before";
  EXPECT_FALSE(leans_on_loose(slabs(), {{3_stone, on_site(0.025, 0.5)}}, placed, below));
}

}  // namespace
}  // namespace stonestack::stacking
