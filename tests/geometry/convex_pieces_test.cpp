#include "geometry/convex_pieces.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/rough_stone.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::geometry {
namespace {

/// Height of a triangle over its longest side.
double lowest_height(const Mesh& mesh, const Eigen::Vector3i& face) {
  const auto at = [&](int k) { return mesh.vertices[static_cast<std::size_t>(face[k])]; };
  const Eigen::Vector3d ab = at(1) - at(0), ac = at(2) - at(0), bc = at(2) - at(1);
  return ab.cross(ac).norm() / std::max({ab.norm(), ac.norm(), bc.norm()});
}

/// How far the furthest vertex of `points` lies outside the convex mesh, by the planes of its faces. Those of
/// slivers, narrower than a micrometre, point anywhere.
double worst_outside(const Mesh& convex, const Mesh& points) {
  const std::vector<Eigen::Vector3d> normals = face_normals(convex);
  double worst = -1e300;
  for (std::size_t f = 0; f < convex.faces.size(); ++f) {
    if (lowest_height(convex, convex.faces[f]) < 1e-6) continue;
    const Eigen::Vector3d& a = convex.vertices[static_cast<std::size_t>(convex.faces[f][0])];
    for (const Eigen::Vector3d& p : points.vertices) worst = std::max(worst, normals[f].dot(p - a));
  }
  return worst;
}

/// A block with a square notch: volume 7/8 of its hull's shape, certainly concave.
Mesh make_l_shape() {
  Mesh mesh;
  const double corners[6][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  for (const double z : {0.0, 1.0})
    for (const auto& c : corners) mesh.vertices.emplace_back(c[0], c[1], z);
  const int caps[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}};
  for (const auto& c : caps) {
    mesh.faces.emplace_back(c[0], c[2], c[1]);
    mesh.faces.emplace_back(c[0] + 6, c[1] + 6, c[2] + 6);
  }
  for (int i = 0; i < 6; ++i) {
    const int j = (i + 1) % 6;
    mesh.faces.emplace_back(i, j, j + 6);
    mesh.faces.emplace_back(i, j + 6, i + 6);
  }
  return mesh;
}

TEST(ConvexHull, OfABoxIsTheBox) {
  Mesh points = make_box({0.1, 0.2, 0.3});
  points.vertices.emplace_back(0.01, 0.02, 0.03);
  const Mesh hull = convex_hull(points);
  EXPECT_EQ(hull.vertices.size(), 8U);
  EXPECT_TRUE(is_closed(hull));
  EXPECT_NEAR(volume(hull), 0.006, 1e-15);
}

TEST(ConvexHull, HoldsTheStoneAndIsConvex) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Mesh stone = make_rough_stone(seed);
    const Mesh hull = convex_hull(stone);
    EXPECT_TRUE(is_closed(hull));
    EXPECT_GE(volume(hull), volume(stone));
    EXPECT_LT(worst_outside(hull, stone), 1e-9);
  }
}

TEST(ConvexHull, RefusesFlatPoints) {
  Mesh flat;
  flat.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0.3, 0.2, 0}};
  EXPECT_THROW((void)convex_hull(flat), InvalidArgument);
  EXPECT_THROW((void)convex_hull(Mesh{}), InvalidArgument);
}

TEST(ConvexPieces, OfAConvexBodyIsOne) {
  const std::vector<Mesh> pieces = convex_pieces(make_box({0.1, 0.2, 0.3}));
  ASSERT_EQ(pieces.size(), 1U);
  EXPECT_NEAR(volume(pieces[0]), 0.006, 1e-9);
}

TEST(ConvexPieces, SplitWhatIsConcave) {
  ConvexPiecesOptions options;
  options.concavity = 10;
  const std::vector<Mesh> pieces = convex_pieces(scaled(make_l_shape(), 0.1), options);
  EXPECT_GE(pieces.size(), 2U);
  EXPECT_LE(pieces.size(), 5U);
  double sum = 0.0;
  for (const Mesh& piece : pieces) {
    EXPECT_TRUE(is_closed(piece));
    EXPECT_LT(worst_outside(piece, piece), 1e-5);
    sum += volume(piece);
  }
  EXPECT_NEAR(sum, 0.003, 0.0004);
}

TEST(ConvexPieces, KeepToTheirLimitsAndAreRepeatable) {
  const Mesh stone = make_rough_stone(2, 2);
  const std::vector<Mesh> pieces = convex_pieces(stone);
  EXPECT_LE(pieces.size(), 5U);
  for (const Mesh& piece : pieces) {
    EXPECT_LE(piece.vertices.size(), 64U);
    EXPECT_TRUE(is_closed(piece));
  }
  const std::vector<Mesh> again = convex_pieces(stone);
  ASSERT_EQ(again.size(), pieces.size());
  for (std::size_t i = 0; i < pieces.size(); ++i) EXPECT_EQ(again[i].vertices, pieces[i].vertices);
}

TEST(ConvexPieces, RefuseOpenMeshes) {
  Mesh open = make_box({1, 1, 1});
  open.faces.pop_back();
  EXPECT_THROW((void)convex_pieces(open), InvalidArgument);
  EXPECT_THROW((void)convex_pieces(make_box({1, 1, 1}), {.max_pieces = 0}), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::geometry
