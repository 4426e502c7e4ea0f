#include "stone/gradient_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "stonestack/core/random.hpp"

namespace stonestack::stone {
namespace {

TEST(GradientNoise, IsZeroOnTheLatticeAndBounded) {
  const GradientNoise noise(7);
  EXPECT_EQ(noise({3.0, -2.0, 11.0}), 0.0);
  Random random(1);
  double sum = 0.0, squares = 0.0;
  for (int n = 0; n < 20000; ++n) {
    const double value = noise({random.uniform(-50, 50), random.uniform(-50, 50), random.uniform(-50, 50)});
    ASSERT_LE(std::abs(value), 1.1);
    sum += value;
    squares += value * value;
  }
  EXPECT_NEAR(sum / 20000, 0.0, 0.01);
  EXPECT_NEAR(std::sqrt(squares / 20000), 0.27, 0.03);  // limestone's roughness is scaled by it
}

TEST(GradientNoise, IsSmoothAcrossLatticeFaces) {
  const GradientNoise noise(3);
  Random random(2);
  for (int n = 0; n < 1000; ++n) {
    const Eigen::Vector3d p(random.index(9), random.uniform(0, 9), random.uniform(0, 9));
    const Eigen::Vector3d step(1e-6, 0, 0);
    EXPECT_NEAR(noise(p - step), noise(p + step), 1e-5);
  }
}

TEST(GradientNoise, DependsOnItsSeed) {
  const Eigen::Vector3d p(0.3, 0.6, 0.2);
  EXPECT_EQ(GradientNoise(1)(p), GradientNoise(1)(p));
  EXPECT_NE(GradientNoise(1)(p), GradientNoise(2)(p));
}

}  // namespace
}  // namespace stonestack::stone
