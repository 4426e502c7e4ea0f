#include "geometry/surface_tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/closest_on_triangle.hpp"
#include "geometry/rough_stone.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::geometry {
namespace {

double brute_distance(const Mesh& mesh, const Eigen::Vector3d& p) {
  double nearest = 1e300;
  for (const Eigen::Vector3i& face : mesh.faces) {
    const Eigen::Vector3d& a = mesh.vertices[static_cast<std::size_t>(face[0])];
    const Eigen::Vector3d ab = mesh.vertices[static_cast<std::size_t>(face[1])] - a;
    const Eigen::Vector3d ac = mesh.vertices[static_cast<std::size_t>(face[2])] - a;
    nearest = std::min(nearest, (p - closest_on_triangle(a, ab, ac, p).point).norm());
  }
  return nearest;
}

TEST(ClosestOnTriangle, IsNearerThanAnyOtherPointOfIt) {
  Random random = Random::stream(1, "triangle");
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d a = random.unit_vector();
    const Eigen::Vector3d ab = random.unit_vector();
    const Eigen::Vector3d ac = random.unit_vector() * random.uniform(0.01, 2.0);
    const Eigen::Vector3d p = 3.0 * random.unit_vector();
    const double distance = (closest_on_triangle(a, ab, ac, p).point - p).norm();
    for (int k = 0; k < 50; ++k) {
      const double s = random.uniform();
      const double t = random.uniform(0.0, 1.0 - s);
      EXPECT_LE(distance, (a + s * ab + t * ac - p).norm() + 1e-12);
    }
  }
}

TEST(SurfaceTree, AgreesWithTryingEveryFace) {
  const Mesh stone = make_rough_stone(1);
  const SurfaceTree tree(stone);
  Random random = Random::stream(2, "surface tree");
  int likely_face = -1;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d p = random.uniform(0.0, 0.15) * random.unit_vector();
    const SurfacePoint nearest = tree.nearest(p, 10.0, likely_face);
    likely_face = nearest.face;
    EXPECT_NEAR(std::abs(nearest.distance), brute_distance(stone, p), 1e-14);
    EXPECT_NEAR((p - nearest.point).norm(), std::abs(nearest.distance), 1e-14);
  }
}

TEST(SurfaceTree, SignIsRightAtEdgesAndCorners) {
  const Mesh box = make_box({0.2, 0.1, 0.05});
  const SurfaceTree tree(box);
  Random random = Random::stream(3, "surface tree");
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d p(random.uniform(-0.2, 0.2), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1));
    const Eigen::Vector3d q = p.cwiseAbs() - Eigen::Vector3d(0.1, 0.05, 0.025);
    const double expected = q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
    EXPECT_NEAR(tree.nearest(p).distance, expected, 1e-14) << p.transpose();
  }
}

TEST(SurfaceTree, ClusterGivesTheSameDistances) {
  const SurfaceTree tree(make_rough_stone(4));
  Random random = Random::stream(4, "surface tree");
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d middle = random.uniform(0.0, 0.12) * random.unit_vector();
    std::vector<Eigen::Vector3d> cluster;
    for (int k = 0; k < 20; ++k) cluster.push_back(middle + random.uniform(0.0, 0.01) * random.unit_vector());
    const std::vector<SurfacePoint> together = tree.nearest(cluster);
    for (std::size_t k = 0; k < cluster.size(); ++k)
      EXPECT_NEAR(together[k].distance, tree.nearest(cluster[k]).distance, 1e-14);
  }
  EXPECT_TRUE(tree.nearest(std::vector<Eigen::Vector3d>{}).empty());
}

TEST(SurfaceTree, NothingWithinTheLimit) {
  const SurfaceTree tree(make_box({1, 1, 1}));
  const SurfacePoint none = tree.nearest({3, 0, 0}, 0.5);
  EXPECT_EQ(none.face, -1);
  EXPECT_EQ(none.distance, 0.5);
}

TEST(SurfaceTree, LeavesOutFacesWithoutArea) {
  Mesh box = make_box({1, 1, 1});
  box.faces.insert(box.faces.begin(), Eigen::Vector3i(0, 0, 1));
  EXPECT_NEAR(SurfaceTree(box).nearest({2, 0, 0}).distance, 1.5, 1e-15);
  Mesh line;
  line.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  line.faces = {{0, 1, 2}};
  EXPECT_THROW(SurfaceTree{line}, InvalidArgument);
}

}  // namespace
}  // namespace stonestack::geometry
