#include "detection/features/describe.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "detection/features/descriptors.hpp"
#include "detection/features/keypoints.hpp"
#include "detection/features/matching.hpp"
#include "detection/features/triangulate.hpp"
#include "detection/test_scene.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/detection/detect_stones.hpp"

namespace stonestack::detection {
namespace {

TEST(Subdivide, KeepsTheSurfaceAndSplitsEveryLongEdge) {
  const TriangulatedSurface fine = subdivide(make_box({0.06, 0.05, 0.04}), 0.004);
  double area = 0, longest = 0;
  for (const auto& t : fine.triangles) {
    const auto p = [&](int k) {
      return fine.surface.points[static_cast<std::size_t>(t[k])].cast<double>().eval();
    };
    area += 0.5 * (p(1) - p(0)).cross(p(2) - p(0)).norm();
    for (int k = 0; k < 3; ++k) longest = std::max(longest, (p((k + 1) % 3) - p(k)).norm());
  }
  EXPECT_NEAR(area, 2 * (0.06 * 0.05 + 0.05 * 0.04 + 0.04 * 0.06), 1e-7);
  EXPECT_LT(longest, 0.004 + 1e-6);
}

TEST(Subdivide, SharesThePointsOfSplitEdges) {
  const TriangulatedSurface fine = subdivide(make_box({0.06, 0.06, 0.06}), 0.01);
  // Euler: a closed surface without holes has V - E + F = 2, and 2 E = 3 F.
  EXPECT_EQ(2 * static_cast<int>(fine.surface.points.size()) - static_cast<int>(fine.triangles.size()), 4);
}

/// How many of the nearest descriptors belong to the same place, for one stone described twice: as it is, and
/// turned.
double share_matched(const std::string& descriptor) {
  const Stone stone = test::make_test_stone(7);
  DetectionOptions options;
  options.descriptor = descriptor;
  const Pose T_B_A = make_pose({0.1, -0.2, 0.4}, Eigen::Quaterniond(0.3, -0.5, 0.7, 0.4));
  const auto describe = [&](const Mesh& mesh) {
    const TriangulatedSurface fine = subdivide(mesh, 0.004);
    std::vector<int> keypoints;
    for (int i = 0; i < 200; ++i) keypoints.push_back(i);  // vertices of the mesh: the same places in both
    return descriptor == "rops"   ? rops_features(fine, keypoints, 0.04)
           : descriptor == "shot" ? shot_features(fine.surface, keypoints, 0.04)
           : descriptor == "iss"  ? iss_features(fine.surface, keypoints, 0.04)
                                  : fpfh_features(fine.surface, keypoints, 0.03);
  };
  const Features a = describe(stone.mesh), b = describe(transformed(stone.mesh, T_B_A));
  int right = 0;
  for (const auto& m : match_features(b, a, 1)) {
    const Eigen::Vector3d back = T_B_A.inverse() * b.points[static_cast<std::size_t>(m.scene)].cast<double>();
    right += (back - a.points[static_cast<std::size_t>(m.model)].cast<double>()).norm() < 0.001 ? 1 : 0;
  }
  return static_cast<double>(right) / 200.0;
}

TEST(Descriptors, ShotDoesNotDependOnThePose) {
  EXPECT_GT(share_matched("shot"), 0.95);
}
TEST(Descriptors, FpfhDoesNotDependOnThePose) {
  EXPECT_GT(share_matched("fpfh"), 0.95);
}
TEST(Descriptors, IssDoesNotDependOnThePose) {
  EXPECT_GT(share_matched("iss"), 0.95);
}
TEST(Descriptors, RopsDoesNotDependOnThePose) {
  EXPECT_GT(share_matched("rops"), 0.95);
}

TEST(Descriptors, RopsWithoutTrianglesIsEmptyAndNoCrash) {
  TriangulatedSurface bare;
  bare.surface.points = {{0, 0, 1}, {0, 0.01F, 1}, {0.01F, 0, 1}};
  const std::vector<int> keypoints{0, 1};
  EXPECT_TRUE(rops_features(bare, keypoints, 0.04).points.empty());
}

TEST(Matching, FindsTheNearestAndSortsByDistance) {
  Features model, scene;
  model.descriptors = Eigen::MatrixXf::Identity(4, 4);
  scene.descriptors.resize(2, 4);
  scene.descriptors << 0, 0.5F, 0, 0, 0, 0, 0, 0.9F;
  const auto matches = match_features(scene, model, 2);
  ASSERT_EQ(matches.size(), 4U);
  EXPECT_EQ(matches[0].scene, 1);
  EXPECT_EQ(matches[0].model, 3);
  EXPECT_NEAR(matches[0].distance, 0.01F, 1e-6F);
  EXPECT_TRUE(std::is_sorted(matches.begin(), matches.end(),
                             [](const auto& a, const auto& b) { return a.distance < b.distance; }));
}

TEST(Matching, AKdTreeFindsTheSame) {
  Random random = Random::stream(5, "descriptors");
  const auto features = [&](int count) {
    Features out;
    out.descriptors.resize(count, 33);
    for (Eigen::Index i = 0; i < out.descriptors.size(); ++i)
      out.descriptors.data()[i] = static_cast<float>(random.uniform());
    return out;
  };
  const Features model = features(80), scene = features(60);
  for (const int k : {1, 3, 100}) {
    const auto exact = match_features(scene, model, k), tree = match_features_kdtree(scene, model, k);
    ASSERT_EQ(exact.size(), tree.size());
    for (std::size_t i = 0; i < exact.size(); ++i) EXPECT_NEAR(exact[i].distance, tree[i].distance, 1e-4);
    std::set<std::pair<int, int>> a, b;
    for (const auto& m : exact) a.emplace(m.scene, m.model);
    for (const auto& m : tree) b.emplace(m.scene, m.model);
    EXPECT_EQ(a, b) << k;
  }
  EXPECT_TRUE(match_features_kdtree(scene, {}, 1).empty());
  EXPECT_TRUE(match_features_kdtree({}, model, 1).empty());
}

TEST(Options, UnknownNamesAreTheCallersFault) {
  DetectionOptions method, descriptor, keypoints;
  method.method = "best";
  EXPECT_THROW(require_usable(method), InvalidArgument);
  descriptor.descriptor = "sift";
  EXPECT_THROW((void)describe_model({}, {}, descriptor), InvalidArgument);
  DetectionOptions matching;
  matching.matching = "guess";
  EXPECT_THROW(require_usable(matching), InvalidArgument);
  EXPECT_THROW((void)options_of("best"), InvalidArgument);
  keypoints.keypoints = "all";
  EXPECT_THROW((void)describe_model({}, {}, keypoints), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::detection
