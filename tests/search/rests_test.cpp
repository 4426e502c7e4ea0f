#include <gtest/gtest.h>

#include "physics/shape.hpp"
#include "search/box_scenes.hpp"
#include "search/top_surface.hpp"

/// Where a stack rests, when that is on sharp corners.
namespace stonestack::search {
namespace {

/// Tips of three base points. A raster of 3 mm about their middle meets the last, and passes the others by 2
/// mm.
const std::array<Eigen::Vector2d, 3> kBasePoints = {
    Eigen::Vector2d(0.0285, 0.04071), Eigen::Vector2d(-0.04951, 0.00433), Eigen::Vector2d(0.02101, -0.04504)};

/// A slab 3 cm thick on three points 3 cm high; their tips at z = 0.
Mesh tripod() {
  constexpr double kHollow = 0.03, kTop = 0.06;
  Mesh mesh;
  const auto add = [&](const Eigen::Vector2d& p, double z) { mesh.vertices.emplace_back(p.x(), p.y(), z); };
  add({0, 0}, kHollow);          // 0: middle of the underside
  for (int k = 0; k < 3; ++k) {  // 1 to 6: its rim, base points and the surface between them
    const Eigen::Vector2d& base = kBasePoints[static_cast<std::size_t>(k)];
    add(base, 0.0);
    add(0.75 * (base + kBasePoints[static_cast<std::size_t>((k + 1) % 3)]), kHollow);
  }
  for (int k = 1; k <= 6; ++k) add(mesh.vertices[static_cast<std::size_t>(k)].head<2>(), kTop);  // 7 to 12
  add({0, 0}, kTop);                                                                             // 13
  for (int k = 0; k < 6; ++k) {
    const int a = 1 + k, b = 1 + (k + 1) % 6;
    mesh.faces.emplace_back(0, b, a);
    mesh.faces.emplace_back(a, b, b + 6);
    mesh.faces.emplace_back(a, b + 6, a + 6);
    mesh.faces.emplace_back(13, a + 6, b + 6);
  }
  return mesh;
}

ShapeList tripod_and_box() {
  ShapeOptions options;
  options.cell = 0.003;
  options.spacing = 0.006;
  return {make_contact_shape(tripod(), mass_properties(tripod(), 2600.0), "tripod", options),
          box("box", {0.07, 0.06, 0.04})};
}

TEST(Rests, AreTheSharpCornersThemselves) {
  const ShapeList shapes = tripod_and_box();
  const std::vector<Rest> rests = rests_of(shapes, Stack{{{0_stone, Pose::Identity()}}});
  ASSERT_EQ(rests.size(), 1U);
  EXPECT_NEAR(rests[0].z, 0.0, 1e-9);
  ASSERT_EQ(rests[0].polygon_W.size(), 3U);
  for (const Eigen::Vector2d& base : kBasePoints)
    EXPECT_TRUE(std::any_of(rests[0].polygon_W.begin(), rests[0].polygon_W.end(),
                            [&](const Eigen::Vector2d& corner) { return (corner - base).norm() < 1e-6; }))
        << base.transpose();
}

TEST(Rests, OfAStoneOnAnotherAreOnThat) {
  const ShapeList shapes = tripod_and_box();
  const std::vector<Rest> rests =
      rests_of(shapes, Stack{{{0_stone, Pose::Identity()}, {1_stone, at(0, 0, 0.08)}}});
  ASSERT_EQ(rests.size(), 2U);
  EXPECT_NEAR(rests[1].z, 0.06, 1e-9);
  EXPECT_GT(area(rests[1].polygon_W), 0.002);
}

TEST(Rests, ABaseOnThreeSharpPointsBearsAnother) {
  const ShapeList shapes = tripod_and_box();
  SearchProblem problem;
  problem.shapes = &shapes;
  problem.stack.stones = {{0_stone, Pose::Identity()}};
  problem.available = {{1_stone, at(0.4, 0, 0.02)}};
  const SearchResult found = find_next_pose(problem, quick());
  EXPECT_FALSE(found.best.empty()) << found.reason;
}

TEST(Rests, ABaseMeasuredTooHighOrTooLowBearsAnother) {
  const ShapeList shapes = tripod_and_box();
  for (const double z : {0.0009, -0.0009}) {
    SearchProblem problem;
    problem.shapes = &shapes;
    problem.stack.stones = {{0_stone, at(0, 0, z)}};
    problem.available = {{1_stone, at(0.4, 0, 0.02)}};
    const SearchResult found = find_next_pose(problem, quick());
    EXPECT_FALSE(found.best.empty()) << z << ": " << found.reason;
  }
}

}  // namespace
}  // namespace stonestack::search
