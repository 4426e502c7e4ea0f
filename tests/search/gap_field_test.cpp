#include "search/gap_field.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "search_scenes.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::search {
namespace {

constexpr double kCell = 0.004;
constexpr int kHalf = 60;

TopSurface surface_of(const std::function<double(double, double)>& height) {
  TopSurface top{HeightRaster({0, 0}, kCell, kHalf), {}};
  for (std::size_t k = 0; k < top.heights.z.size(); ++k) {
    const Eigen::Vector2d p = top.heights.node(static_cast<int>(k));
    top.heights.z[k] = static_cast<float>(height(p.x(), p.y()));
  }
  top.may_touch.assign(top.heights.z.size(), 1);
  return top;
}

Underside underside_of(const Mesh& mesh, const Eigen::Matrix3d& R = Eigen::Matrix3d::Identity()) {
  UndersideOptions options;
  options.cell = kCell;
  options.stride = 2 * kHalf + 1;
  return make_underside(mesh.vertices, mesh.faces, R, options);
}

TEST(HeightRaster, FollowsATiltedTriangle) {
  HeightRaster raster({0, 0}, 0.01, 10);
  const std::vector<Eigen::Vector3d> vertices = {{-0.1, -0.1, 0.0}, {0.1, -0.1, 0.2}, {-0.1, 0.1, 0.0}};
  raise_to(raster, vertices, std::vector<Eigen::Vector3i>{{0, 1, 2}});
  EXPECT_NEAR(raster.z[static_cast<std::size_t>(raster.index(-3, -2))], 0.07, 1e-6);
  EXPECT_EQ(raster.z[static_cast<std::size_t>(raster.index(5, 5))], kNoSurface);
  EXPECT_NEAR(raster.node(raster.index(-3, 2)).y(), 0.02, 1e-12);
}

TEST(HeightRaster, OfAClosedSurfaceOneWindingIsEnough) {
  Mesh mesh = make_sphere(0.05, 2);
  for (std::size_t k = 0; k < mesh.vertices.size(); ++k) mesh.vertices[k] *= 1.0 - 0.01 * (k % 7);
  HeightRaster all({0, 0}, 0.002, 30), upper = all, lower = all, below = all;
  raise_to(all, mesh.vertices, mesh.faces);
  raise_to(upper, mesh.vertices, mesh.faces, Winding::kCounterclockwise);
  EXPECT_EQ(upper.z, all.z);
  raise_to(lower, mesh.vertices, mesh.faces, Winding::kClockwise);
  EXPECT_NE(lower.z, all.z);
  std::vector<Eigen::Vector3d> negated = mesh.vertices;
  for (auto& v : negated) v.z() = -v.z();
  HeightRaster all_below({0, 0}, 0.002, 30);
  raise_to(all_below, negated, mesh.faces);
  raise_to(below, negated, mesh.faces, Winding::kClockwise);
  EXPECT_EQ(below.z, all_below.z);
}

TEST(GapField, BoxLiesFlatOnATable) {
  const TopSurface table = surface_of([](double, double) { return 0.5; });
  GapField field;
  const Underside box = underside_of(make_box({0.1, 0.08, 0.06}));
  lay(table, box, 3, -2, 0.022, &field);
  const GapRest rest = solve_rest(field, table, 0.2);
  ASSERT_TRUE(rest.rests);
  EXPECT_TRUE(rest.clean);
  EXPECT_NEAR(rest.height, 0.53, 1e-5);
  EXPECT_NEAR(rest.a, 0.0, 1e-4);
  EXPECT_NEAR(rest.b, 0.0, 1e-4);
  const GapContact contact = contact_of(field, rest, table, 0.0006);
  EXPECT_NEAR(contact.margin, 0.04, 0.0003);  // half the shorter side
  EXPECT_NEAR(contact.height, 0.03, 1e-5);
}

TEST(GapField, BoxTakesTheTiltOfAPlane) {
  const TopSurface slope = surface_of([](double x, double y) { return 0.1 + 0.10 * x - 0.05 * y; });
  GapField field;
  const Underside box = underside_of(make_box({0.1, 0.08, 0.06}));
  lay(slope, box, 0, 0, 0.022, &field);
  const GapRest rest = solve_rest(field, slope, 0.2);
  ASSERT_TRUE(rest.rests);
  EXPECT_NEAR(rest.a, 0.10, 1e-3);
  EXPECT_NEAR(rest.b, -0.05, 1e-3);
  EXPECT_NEAR(rest.height, 0.13, 1e-4);
}

TEST(GapField, SphereSitsOnThreeSpheres) {
  // Four equal spheres in a tetrahedron: the upper one lies 2 r sqrt(2/3) above the others, touching at
  // r / sqrt(3) from the axis.
  const double r = 0.04, ring = 2.0 * r / std::sqrt(3.0);
  const TopSurface cradle = surface_of([&](double x, double y) {
    double z = -1.0;
    for (int k = 0; k < 3; ++k) {
      const double angle = 2.0943951023931953 * k;
      const double dx = x - ring * std::cos(angle), dy = y - ring * std::sin(angle);
      if (const double h = r * r - dx * dx - dy * dy; h > 0) z = std::max(z, std::sqrt(h));
    }
    return z;
  });
  GapField field;
  const Underside sphere = underside_of(make_sphere(r, 5));
  lay(cradle, sphere, 0, 0, 0.022, &field);
  const GapRest rest = solve_rest(field, cradle, 0.2);
  ASSERT_TRUE(rest.rests);
  EXPECT_NEAR(rest.height, 2.0 * r * std::sqrt(2.0 / 3.0), 0.0005);
  const GapContact contact = contact_of(field, rest, cradle, 0.0003);
  EXPECT_NEAR(contact.margin, 0.5 * r / std::sqrt(3.0), 0.006);
}

TEST(GapField, OverhangingBoxTips) {
  const TopSurface ledge = surface_of([](double x, double) { return x < 0.0 ? 0.3 : 0.0; });
  GapField field;
  const Underside box = underside_of(make_box({0.1, 0.1, 0.06}));
  lay(ledge, box, 4, 0, 0.022, &field);  // centre of mass 16 mm beyond the edge
  EXPECT_FALSE(solve_rest(field, ledge, 0.2).rests);
  lay(ledge, box, -4, 0, 0.022, &field);
  EXPECT_TRUE(solve_rest(field, ledge, 0.2).rests);
}

TEST(GapField, RestDoesNotDependOnWhereItsSearchBegins) {
  Random random = Random::stream(9, "gap field");
  int rested = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const double p = random.uniform(10, 40), s = random.uniform(0, 6);
    const TopSurface top = surface_of([&](double x, double y) {
      return 0.004 * (std::sin(p * x + s) + std::cos(30 * y + p * x * y * 20));
    });
    const Underside side = underside_of(make_sphere(0.3, 3));
    std::array<int, 3> cells = kArtificial;
    for (int i = -6; i <= 6; i += 2) {
      GapField field;
      lay(top, side, i, 1, 0.022, &field);
      const GapRest anew = solve_rest(field, top, 0.2);
      const GapRest from = solve_rest(field, top, 0.2, cells);
      ASSERT_EQ(anew.rests, from.rests);
      ASSERT_NEAR(anew.height, from.height, 2e-5);
      if (anew.rests) ++rested;
      cells = from.cells;
    }
  }
  EXPECT_GT(rested, 200);
}

/// Where a stone tips over a ledge, artificial cells are left in its basis, in any order. On rough surfaces
/// one rest in a thousand still depends on its start, by ties; with artificial cells mixed up it was one in
/// 400.
TEST(GapField, TheSearchForARestGoesOnFromOneThatTips) {
  Random random = Random::stream(9, "gap field");
  int different = 0, all = 0, tipped = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const double p = random.uniform(10, 40), s = random.uniform(0, 6), rough = random.uniform(0.002, 0.02);
    const double drop = trial % 2 == 0 ? 0.0 : random.uniform(0.03, 0.3), edge = random.uniform(-0.02, 0.02);
    const TopSurface top = surface_of([&](double x, double y) {
      return rough * (std::sin(p * x + s) + std::cos(30 * y + p * x * y * 20)) - (x > edge ? drop : 0.0);
    });
    const Underside side = underside_of(make_sphere(0.3, 3));
    std::array<int, 3> cells = kArtificial;
    for (int i = -6; i <= 6; ++i) {
      GapField field;
      lay(top, side, i, 1, 1.0, &field);
      const GapRest anew = solve_rest(field, top, 0.2);
      const GapRest from = solve_rest(field, top, 0.2, cells);
      different += anew.rests != from.rests || std::abs(anew.height - from.height) > 2e-5 ? 1 : 0;
      tipped += anew.rests ? 0 : 1;
      ++all;
      cells = from.cells;
    }
  }
  EXPECT_GT(tipped, all / 20);
  EXPECT_LT(different, all / 600);
}

TEST(GapField, RestingPlaneLiesAboveEveryCellAndEnclosesTheCentre) {
  Random random = Random::stream(7, "gap field");
  int rested = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const double p = random.uniform(10, 40), q = random.uniform(10, 40), s = random.uniform(0, 6);
    const double rough = random.uniform(0.001, 0.006);
    const TopSurface top = surface_of(
        [&](double x, double y) { return rough * (std::sin(p * x + s) + std::cos(q * y + p * x * y * 20)); });
    GapField field;
    const Underside side = underside_of(make_sphere(0.3, 3));
    lay(top, side, 0, 0, 0.022, &field);
    const GapRest rest = solve_rest(field, top, 0.2);
    if (!rest.rests) continue;
    ++rested;
    for (const int run : field.runs)
      for (int n = run * kRun; n < (run + 1) * kRun; ++n) {
        const auto k = static_cast<std::size_t>(n);
        ASSERT_LE(
            static_cast<double>(field.d[k]) - 2e-5,
            rest.height + rest.a * static_cast<double>(side.x[k]) + rest.b * static_cast<double>(side.y[k]));
      }
    Polygon2 corners;
    for (const int cell : rest.cells)
      corners.emplace_back(static_cast<double>(side.x[static_cast<std::size_t>(cell)]),
                           static_cast<double>(side.y[static_cast<std::size_t>(cell)]));
    ASSERT_GE(margin(convex_hull(corners), Eigen::Vector2d(0, 0)), -1e-9);
  }
  EXPECT_GT(rested, 100);
}

}  // namespace
}  // namespace stonestack::search
