#include "physics/touch.hpp"

#include <gtest/gtest.h>

#include "physics/bodies.hpp"
#include "stonestack/core/error.hpp"

/// Touches of kept pairs of features against those of pairs looked up anew.
namespace stonestack::physics {
namespace {

using test::at;
using test::lump;

/// A pose displaced by about `step` m and as much at the rim of a stone of 0.05 m.
Pose displaced(const Pose& T, double step, Random& random) {
  Pose moved = T;
  Eigen::Vector3d turn;
  for (int axis = 0; axis < 3; ++axis) {
    moved.translation()[axis] += random.normal(0.0, step);
    turn[axis] = random.normal(0.0, step / 0.05);
  }
  moved.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * T.linear();
  return moved;
}

TEST(FeaturePairs, KeptPairsMissNothingWhateverTheMotion) {
  const auto below = lump(1), above = lump(11);
  const Surface A{above->features.get(), &above->distance, {}};
  const Surface B{below->features.get(), &below->distance, {}};
  const Pose T_W_B = at(0, 0, 0.04);
  long compared = 0;
  for (const double step : {2e-6, 2e-5, 1e-4, 6e-4}) {
    Random random = Random::stream(3, concat("motion ", step));
    FeaturePairs kept;
    const Pose start = at(0.004, 0.002, 0.107, 0.7);
    Pose T_W_A = start;
    for (int k = 0; k < 300; ++k) {
      T_W_A = displaced(T_W_A, step, random);
      if (difference(start, T_W_A).translation > 0.004) T_W_A = start;
      const std::vector<Touch> now = kept.touches(A, B, T_W_A, T_W_B);
      const std::vector<Touch> anew = FeaturePairs().touches(A, B, T_W_A, T_W_B);
      ASSERT_EQ(now.size(), anew.size()) << "step " << step << ", look " << k;
      for (std::size_t i = 0; i < now.size(); ++i) {
        ASSERT_EQ(now[i].kind, anew[i].kind);
        ASSERT_EQ(now[i].a, anew[i].a);
        ASSERT_EQ(now[i].b, anew[i].b);
        ASSERT_EQ(now[i].gap, anew[i].gap);
      }
      compared += static_cast<long>(now.size());
    }
  }
  EXPECT_GT(compared, 500);
}

}  // namespace
}  // namespace stonestack::physics
