#include "stonestack/geometry/mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "core/constants.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::geometry {
namespace {

TEST(Mesh, OfABoxIsExact) {
  const Mesh box = make_box({1, 2, 3});
  EXPECT_EQ(box.faces.size(), 12U);
  EXPECT_TRUE(is_closed(box));
  EXPECT_NEAR(volume(box), 6.0, 1e-14);
  EXPECT_NEAR(surface_area(box), 22.0, 1e-14);
  EXPECT_EQ(bounds(box).min(), Eigen::Vector3d(-0.5, -1, -1.5));
  for (std::size_t f = 0; f < box.faces.size(); ++f) {
    const Eigen::Vector3d n = face_normals(box)[f];
    EXPECT_NEAR(n.cwiseAbs().maxCoeff(), 1.0, 1e-15);
    EXPECT_GT(n.dot(box.vertices[static_cast<std::size_t>(box.faces[f][0])]), 0.0) << "points inwards";
  }
}

TEST(Mesh, BoxCornerNormalsAreDiagonalsWhateverTheTriangulation) {
  const Mesh box = make_box({1, 1, 1});
  const auto normals = vertex_normals(box);
  for (std::size_t v = 0; v < normals.size(); ++v)
    EXPECT_LT((normals[v] - box.vertices[v].normalized()).norm(), 1e-14);
}

TEST(Mesh, SphereConverges) {
  const Mesh sphere = make_sphere(0.5, 4);
  EXPECT_EQ(sphere.faces.size(), 5120U);
  EXPECT_EQ(sphere.vertices.size(), 2562U);
  EXPECT_TRUE(is_closed(sphere));
  EXPECT_NEAR(volume(sphere) / (kPi / 6.0), 1.0, 3e-3);
  EXPECT_NEAR(surface_area(sphere) / kPi, 1.0, 2e-3);
}

TEST(Mesh, VolumeIsKeptUnderMotionAndCubedUnderScale) {
  Random random = Random::stream(1, "mesh");
  const Mesh stone = make_sphere(0.1, 2);
  for (int i = 0; i < 20; ++i) {
    const Pose pose = make_pose(100.0 * random.unit_vector(), random.rotation());
    EXPECT_NEAR(volume(transformed(stone, pose)) / volume(stone), 1.0, 1e-10);
  }
  EXPECT_NEAR(volume(scaled(stone, 0.01)) / volume(stone), 1e-6, 1e-18);
  EXPECT_THROW((void)scaled(stone, -1.0), InvalidArgument);
}

TEST(Mesh, ClosedMeansEveryEdgeTwiceInOppositeDirections) {
  Mesh open = make_box({1, 1, 1});
  open.faces.pop_back();
  EXPECT_FALSE(is_closed(open));
  Mesh flipped = make_box({1, 1, 1});
  std::swap(flipped.faces[3][0], flipped.faces[3][1]);
  EXPECT_FALSE(is_closed(flipped));
  Mesh doubled = make_box({1, 1, 1});
  doubled.faces.push_back(doubled.faces[0]);
  EXPECT_FALSE(is_closed(doubled));
  Mesh degenerate = make_box({1, 1, 1});
  degenerate.faces.emplace_back(0, 0, 0);
  EXPECT_FALSE(is_closed(degenerate));
  EXPECT_FALSE(is_closed(Mesh{}));
}

TEST(SurfaceSample, AreasSumToTheSurface) {
  for (const Mesh& mesh : {make_box({0.2, 0.1, 0.05}), make_sphere(0.1, 1), make_sphere(0.1, 3)}) {
    for (const double spacing : {0.003, 0.02, 1.0}) {
      double sum = 0.0;
      for (const SurfaceSample& sample : sample_surface(mesh, spacing)) sum += sample.area;
      EXPECT_NEAR(sum / surface_area(mesh), 1.0, 1e-12);
    }
  }
}

TEST(SurfaceSample, LeavesNoHoleAndLiesOnTheSurface) {
  const Mesh box = make_box({0.2, 0.1, 0.05});
  const auto samples = sample_surface(box, 0.01);
  const Eigen::Vector3d half(0.1, 0.05, 0.025);
  for (const SurfaceSample& sample : samples) {
    EXPECT_NEAR((sample.point.cwiseAbs() - half).maxCoeff(), 0.0, 1e-12);
    EXPECT_NEAR(sample.normal.norm(), 1.0, 1e-12);
    EXPECT_GT(sample.normal.dot(sample.point), 0.0);
    EXPECT_GT(sample.area, 0.0);
  }
  Random random = Random::stream(2, "samples");
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d p(random.uniform(-0.1, 0.1), random.uniform(-0.05, 0.05), 0.025);
    double nearest = 1.0;
    for (const SurfaceSample& sample : samples) nearest = std::min(nearest, (sample.point - p).norm());
    EXPECT_LT(nearest, 0.01);
  }
}

TEST(SurfaceSample, WithoutSplitsIsTheVertices) {
  EXPECT_EQ(sample_surface(make_box({1, 1, 1}), 10.0).size(), 8U);
  EXPECT_THROW((void)sample_surface(make_box({1, 1, 1}), 0.0), InvalidArgument);
  EXPECT_THROW((void)sample_surface(make_box({1, 1, 1}), 1e-7), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::geometry
