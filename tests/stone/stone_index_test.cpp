#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <type_traits>
#include <unordered_set>

#include "stonestack/core/error.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack::stone {
namespace {

// What the type is for: the compiler refuses an integer for a stone, and a stone for an integer.
static_assert(!std::is_convertible_v<int, StoneIndex>);
static_assert(!std::is_convertible_v<std::size_t, StoneIndex>);
static_assert(!std::is_convertible_v<StoneIndex, int>);
static_assert(!std::is_convertible_v<StoneIndex, std::size_t>);
static_assert(!std::is_convertible_v<StoneIndex, bool>);
static_assert(!std::is_assignable_v<StoneIndex&, int>);
static_assert(std::is_constructible_v<StoneIndex, int>);
static_assert(std::is_constructible_v<StoneIndex, std::size_t>);
static_assert(!std::is_constructible_v<StoneIndex, double>, "a length is no index");
static_assert(!std::is_constructible_v<StoneIndex, bool>);
static_assert(!std::is_constructible_v<int, StoneIndex>);

template <class A, class B>
concept Comparable = requires(A a, B b) {
  a == b;
};
template <class A, class B>
concept Addable = requires(A a, B b) {
  a + b;
};
template <class List>
concept Subscriptable = requires(List list) {
  list[StoneIndex(0)];
};
static_assert(Comparable<StoneIndex, StoneIndex>);
static_assert(!Comparable<StoneIndex, int>);
static_assert(!Addable<StoneIndex, int>);
static_assert(Subscriptable<const Catalogue>);
static_assert(!Subscriptable<std::vector<int>>, "at() takes it, which checks the range");

using Moves = void (*)(StoneIndex stone, int level);
static_assert(std::is_invocable_v<Moves, StoneIndex, int>);
static_assert(!std::is_invocable_v<Moves, int, StoneIndex>, "arguments cannot be swapped");

static_assert(std::is_trivially_copyable_v<StoneIndex> && sizeof(StoneIndex) == sizeof(int));
static_assert(2_stone == StoneIndex(2));

TEST(StoneIndex, IsNoStoneUntilItIsGivenOne) {
  EXPECT_EQ(StoneIndex(), kNoStone);
  EXPECT_EQ(kNoStone.value(), -1);
  EXPECT_EQ(PlacedStone().stone, kNoStone);
  EXPECT_NE(0_stone, kNoStone);
}

TEST(StoneIndex, OrdersAndHashesAsItsNumber) {
  EXPECT_LT(kNoStone, 0_stone);
  EXPECT_LT(2_stone, 10_stone);
  const std::map<StoneIndex, int> sorted{{10_stone, 0}, {2_stone, 0}, {kNoStone, 0}};
  EXPECT_EQ(sorted.begin()->first, kNoStone);
  EXPECT_EQ(sorted.rbegin()->first, 10_stone);
  const std::unordered_set<StoneIndex> set{1_stone, 1_stone, 2_stone};
  EXPECT_EQ(set.size(), 2U);
}

TEST(StoneIndex, IsWrittenAndReadAsItsNumber) {
  EXPECT_EQ(core::concat(7_stone, ' ', kNoStone), "7 -1");
  const nlohmann::json json = {{"stone", 7_stone}, {"stones", std::vector{0_stone, 2_stone}}};
  EXPECT_EQ(json.dump(), R"({"stone":7,"stones":[0,2]})");
  EXPECT_EQ(json.at("stone").get<StoneIndex>(), 7_stone);
  EXPECT_EQ(json.at("stones").get<std::vector<StoneIndex>>(), (std::vector{0_stone, 2_stone}));
}

TEST(StoneIndex, SubscriptsListsInTheOrderOfTheCatalogue) {
  Catalogue catalogue;
  catalogue.stones.resize(2);
  catalogue.stones[1].name = "second";
  EXPECT_EQ(catalogue[1_stone].name, "second");
  EXPECT_EQ(catalogue.index("second"), 1_stone);
  std::vector<double> heights{0.1, 0.2};
  at(heights, 1_stone) = 0.3;
  EXPECT_EQ(heights[1], 0.3);
  EXPECT_EQ(first_stones(3), (std::vector{0_stone, 1_stone, 2_stone}));
  EXPECT_TRUE(first_stones(0).empty());
}

TEST(StoneIndex, AStoneThatAListHasNotIsRefused) {
  const std::vector<double> heights{0.1, 0.2};
  EXPECT_TRUE((1_stone).is_within(heights.size()));
  EXPECT_FALSE((2_stone).is_within(heights.size()));
  EXPECT_FALSE(kNoStone.is_within(heights.size()));
  EXPECT_THROW(static_cast<void>(at(heights, kNoStone)), core::InvalidArgument);
  try {
    static_cast<void>(at(heights, 2_stone));
    FAIL() << "there is no third";
  } catch (const core::InvalidArgument& error) {
    EXPECT_STREQ(error.what(), "no stone 2; there are 2");
  }
}

}  // namespace
}  // namespace stonestack::stone
