#include "core/recently_used.hpp"

#include <gtest/gtest.h>

namespace stonestack::core {
namespace {

std::shared_ptr<const int> value(int number) {
  return std::make_shared<const int>(number);
}

TEST(RecentlyUsed, KeepsTheLastThatWereUsed) {
  RecentlyUsed<int> cache(2);
  for (const int key : {1, 2}) (void)cache.keep(static_cast<std::uint64_t>(key), value(10 * key));
  ASSERT_TRUE(cache.find(1)) << "used again, so that 2 is the oldest";
  (void)cache.keep(3, value(30));
  EXPECT_EQ(*cache.find(1), 10);
  EXPECT_EQ(*cache.find(3), 30);
  EXPECT_FALSE(cache.find(2));
}

TEST(RecentlyUsed, FindsThoseThatSomebodyHolds) {
  RecentlyUsed<int> cache(1);
  const auto held = cache.keep(1, value(10));
  (void)cache.keep(2, value(20));
  EXPECT_EQ(cache.find(1), held);
}

TEST(RecentlyUsed, IsForgottenWithAllOthers) {
  RecentlyUsed<int> one(2), other(2);
  const auto held = one.keep(1, value(10));
  (void)one.keep(2, value(20));
  (void)other.keep(1, value(30));
  forget_recently_used();
  EXPECT_EQ(one.find(1), held) << "somebody holds it";
  EXPECT_FALSE(one.find(2));
  EXPECT_FALSE(other.find(1));
}

TEST(RecentlyUsed, IsNoLongerListedOnceItIsGone) {
  { RecentlyUsed<int> gone(2); }
  forget_recently_used();
}

}  // namespace
}  // namespace stonestack::core
