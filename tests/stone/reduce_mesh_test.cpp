#include "stone/reduce_mesh.hpp"

#include <gtest/gtest.h>

#include "stone/geodesic.hpp"
#include "stone/mesh_deviation.hpp"
#include "stone/repair_mesh.hpp"
#include "stonestack/stone/model_stone.hpp"

namespace stonestack::stone {
namespace {

TEST(ReduceMesh, KeepsASphereRoundClosedAndOfItsVolume) {
  const Mesh sphere = scaled(make_geodesic(15), 0.07);
  const Mesh reduced = reduce_mesh(sphere, 500);
  EXPECT_LE(reduced.faces.size(), 500U);
  EXPECT_GE(reduced.faces.size(), 490U);
  EXPECT_TRUE(is_closed(reduced));
  EXPECT_NEAR(volume(reduced) / volume(sphere), 1.0, 0.01);
  EXPECT_LT(deviation(sphere, reduced, 0.003).worst, 0.001);
}

TEST(ReduceMesh, TakesAnOddLimit) {
  EXPECT_EQ(reduce_mesh(make_geodesic(6), 101).faces.size(), 100U);
}

TEST(ReduceMesh, LeavesASmallMeshAlone) {
  EXPECT_EQ(reduce_mesh(make_box({1, 1, 1}), 500).faces.size(), 12U);
}

TEST(ReduceMesh, FollowsLimestonesForManySeeds) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Mesh stone = make_limestone(seed);
    const Mesh reduced = reduce_mesh(stone, 500);
    EXPECT_LE(reduced.faces.size(), 500U);
    EXPECT_TRUE(is_closed(reduced));
    EXPECT_EQ(count_self_intersections(reduced), 0) << "seed " << seed;
    const Deviation off = deviation(stone, reduced, 0.003);
    EXPECT_LT(off.median, 0.0005) << "seed " << seed;
    EXPECT_LT(off.worst, 0.004) << "seed " << seed;
  }
}

}  // namespace
}  // namespace stonestack::stone
