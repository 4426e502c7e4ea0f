#include "core/quantile.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "stonestack/core/error.hpp"

namespace stonestack::core {
namespace {

TEST(Quantile, IsTheValueThatAShareLiesBelow) {
  std::vector<double> values;
  for (int k = 99; k >= 0; --k) values.push_back(k);
  EXPECT_EQ(quantile(values, 0.0), 0.0);
  EXPECT_EQ(quantile(values, 0.05), 5.0);
  EXPECT_EQ(quantile(values, 0.5), 50.0);
  EXPECT_EQ(quantile(values, 0.95), 95.0);
  EXPECT_EQ(quantile(values, 1.0), 99.0);
}

TEST(Quantile, OfFewValues) {
  EXPECT_EQ(quantile({3.0}, 0.0), 3.0);
  EXPECT_EQ(quantile({3.0}, 1.0), 3.0);
  EXPECT_EQ(quantile({2.0, 1.0}, 0.5), 2.0) << "the upper median";
  EXPECT_TRUE(std::isnan(quantile({}, 0.5))) << "nothing was measured";
}

TEST(Quantile, RefusesSharesThatAreNone) {
  EXPECT_THROW((void)quantile({1.0}, -0.1), InvalidArgument);
  EXPECT_THROW((void)quantile({1.0}, 95.0), InvalidArgument);
  EXPECT_THROW((void)quantile({1.0}, std::nan("")), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::core
