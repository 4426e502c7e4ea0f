#include "stonestack/core/random.hpp"

#include <gtest/gtest.h>

#include <array>

namespace stonestack::core {
namespace {

TEST(Random, StreamsAreReproducibleAndIndependent) {
  Random first = Random::stream(7, 1);
  Random again = Random::stream(7, 1);
  Random other = Random::stream(7, 2);
  int equal = 0;
  for (int i = 0; i < 100; ++i) {
    const auto bits = first.bits();
    EXPECT_EQ(bits, again.bits());
    equal += bits == other.bits() ? 1 : 0;
  }
  EXPECT_EQ(equal, 0);
}

// Golden: fixes the generator for good; every seeded result in the project depends on it.
TEST(Random, FirstNumbersNeverChange) {
  Random random(1);
  EXPECT_EQ(random.bits(), 0xb3f2af6d0fc710c5ULL);
}

TEST(Random, NormalHasMeanZeroAndSigmaOne) {
  Random random(3);
  double sum = 0, squares = 0;
  constexpr int kDraws = 200000;
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.normal();
    sum += x;
    squares += x * x;
  }
  EXPECT_NEAR(sum / kDraws, 0.0, 0.01);
  EXPECT_NEAR(squares / kDraws, 1.0, 0.02);
}

TEST(Random, RotationsAreUniform) {
  Random random(5);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  std::array<int, 8> octants{};
  for (int i = 0; i < 40000; ++i) {
    const Eigen::Vector3d x = random.rotation() * Eigen::Vector3d::UnitX();
    mean += x / 40000;
    ++octants[(x.x() > 0 ? 1 : 0) + (x.y() > 0 ? 2 : 0) + (x.z() > 0 ? 4 : 0)];
  }
  EXPECT_LT(mean.norm(), 0.02);
  for (const int count : octants) EXPECT_NEAR(count, 5000, 300);
}

TEST(Random, ShuffleIsAPermutation) {
  std::array<int, 6> order{0, 1, 2, 3, 4, 5};
  Random(9).shuffle(order.begin(), order.end());
  std::array<int, 6> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(sorted, (std::array<int, 6>{0, 1, 2, 3, 4, 5}));
  EXPECT_NE(order, sorted);
}

}  // namespace
}  // namespace stonestack::core
