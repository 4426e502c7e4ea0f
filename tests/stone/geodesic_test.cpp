#include "stone/geodesic.hpp"

#include <gtest/gtest.h>

#include "stonestack/core/error.hpp"

namespace stonestack::stone {
namespace {

TEST(Geodesic, IsAClosedUnitSphereOfTwentyFrequencySquaredFaces) {
  for (const int frequency : {1, 2, 3, 7, 14}) {
    const Mesh mesh = make_geodesic(frequency);
    EXPECT_EQ(mesh.faces.size(), 20U * static_cast<unsigned>(frequency * frequency));
    EXPECT_EQ(mesh.vertices.size(), 10U * static_cast<unsigned>(frequency * frequency) + 2U);
    EXPECT_TRUE(is_closed(mesh));
    EXPECT_GT(volume(mesh), 0.0);
    for (const Eigen::Vector3d& v : mesh.vertices) EXPECT_NEAR(v.norm(), 1.0, 1e-12);
  }
}

TEST(Geodesic, RefusesAFrequencyOfNone) {
  EXPECT_THROW((void)make_geodesic(0), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::stone
