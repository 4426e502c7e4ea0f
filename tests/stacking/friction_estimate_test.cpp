#include <gtest/gtest.h>

#include "stacking/run_memory.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

TEST(FrictionEstimate, BeginsWithMoreForMore) {
  const FrictionEstimate estimate = first_estimate({0.1, 0.225, 0.35, 0.475});
  for (std::size_t level = 0; level < 4; ++level)
    EXPECT_NEAR(estimate.weights[level], 0.1 * static_cast<double>(level + 1), 1e-12);
  EXPECT_FALSE(min_is_likeliest(estimate));
}

TEST(FrictionEstimate, AFallThatMoreFrictionWouldHavePreventedMakesItLessLikely) {
  FrictionEstimate estimate = first_estimate({0.1, 0.225, 0.35, 0.475});
  estimate = update_estimate(estimate, {0.0, 0.5, 1.0, 1.0});
  // By hand: 1 x 1, 2 x 0.625, 3 x 0.25, 4 x 0.25 of 4.
  EXPECT_NEAR(estimate.weights[0], 0.25, 1e-12);
  EXPECT_NEAR(estimate.weights[1], 0.3125, 1e-12);
  EXPECT_NEAR(estimate.weights[2], 0.1875, 1e-12);
  EXPECT_NEAR(estimate.weights[3], 0.25, 1e-12);
  estimate = update_estimate(estimate, {0.0, 0.5, 1.0, 1.0});
  EXPECT_TRUE(min_is_likeliest(estimate));
}

TEST(FrictionEstimate, AFallThatNoFrictionExplainsChangesNothing) {
  FrictionEstimate estimate = first_estimate({0.1, 0.225});
  for (int k = 0; k < 100; ++k) estimate = update_estimate(estimate, {1.0, 1.0});
  EXPECT_NEAR(estimate.weights[0], 1.0 / 3.0, 1e-12);
}

TEST(FrictionEstimate, AMeasurementMakesFrictionsNearItLikely) {
  const FrictionEstimate first = first_estimate({0.1, 0.225, 0.35, 0.475});
  const FrictionEstimate slippery = update_by_measurement(first, 0.14);
  // By hand: 1 exp(-0.08), 2 exp(-0.36125), 3 exp(-2.205), 4 exp(-5.61125) of their sum 2.6634.
  EXPECT_NEAR(slippery.weights[0], 0.3466, 1e-3);
  EXPECT_NEAR(slippery.weights[1], 0.5232, 1e-3);
  EXPECT_NEAR(slippery.weights[2], 0.1242, 1e-3);
  EXPECT_NEAR(slippery.weights[3], 0.0055, 1e-3);
  EXPECT_NEAR(update_by_measurement(first, 0.475).weights[3], 0.7323, 1e-3);
  const FrictionEstimate beyond = update_by_measurement(first, 1.2);
  EXPECT_EQ(beyond.weights, update_by_measurement(first, 0.475).weights) << "as much as any that is assumed";
}

TEST(FrictionEstimate, WantsASuccessForEach) {
  FrictionEstimate estimate = first_estimate({0.1, 0.225});
  EXPECT_THROW(static_cast<void>(update_estimate(estimate, {1.0})), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::stacking
