#include <gtest/gtest.h>

#include <cmath>

#include "stacking/box_shape.hpp"
#include "stacking/choose_placement.hpp"
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

/// Slabs are put down upon a post of 3 cm with 18 mm of error along each axis: by that the middle lies above
/// the post in 0.595^2 = 0.35 of the cases.
TEST(FrictionEstimate, AnUnlikelyPlacementCountsInWhatIsExpected) {
  const ShapeList shapes = {box("post", {0.03, 0.03, 0.06}), box("slab", {0.08, 0.08, 0.04})};
  SearchProblem problem;
  problem.shapes = &shapes;
  problem.stack.stones = {{0_stone, make_pose(Eigen::Vector3d(0, 0, 0.03))}};
  problem.available = {{1_stone, make_pose(Eigen::Vector3d(0.4, 0, 0.02))}};
  SearchOptions options;
  options.placement_sigma_translation = 0.018;
  options.placement_sigma_rotation = 0.001;
  options.com_sigma = 0.0;
  options.perturbations = 64;
  ASSERT_EQ(options.min_success, 0.5);
  const PlacedStone slab{1_stone, make_pose(Eigen::Vector3d(0, 0, 0.08))};
  for (const double expected :
       expected_by_friction(problem, {slab}, {0.3, 0.5}, {true, true}, nullptr, options))
    EXPECT_NEAR(expected, 0.354, 3 * std::sqrt(0.354 * 0.646 / 64));
}

}  // namespace
}  // namespace stonestack::stacking
