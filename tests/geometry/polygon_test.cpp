#include "geometry/polygon.hpp"

#include <gtest/gtest.h>

#include "stonestack/core/random.hpp"

namespace stonestack::geometry {
namespace {

TEST(Polygon, HullDropsInnerCollinearAndRepeatedPoints) {
  const Polygon2 hull = convex_hull({{0, 0}, {1, 0}, {2, 0}, {2, 2}, {0, 2}, {1, 1}, {2, 1}, {0, 0}, {2, 2}});
  EXPECT_EQ(hull.size(), 4U);
  EXPECT_NEAR(area(hull), 4.0, 1e-15);
  EXPECT_LT((centroid(hull) - Eigen::Vector2d(1, 1)).norm(), 1e-15);
}

TEST(Polygon, CollinearPointsGiveASegment) {
  EXPECT_EQ(convex_hull({{0, 0}, {1, 1}, {2, 2}, {3, 3}}).size(), 2U);
  EXPECT_EQ(convex_hull({{1, 1}, {1, 1}}).size(), 1U);
  EXPECT_TRUE(convex_hull({}).empty());
}

TEST(Polygon, MarginIsTheDistanceToTheBorder) {
  const Polygon2 square = convex_hull({{0, 0}, {2, 0}, {2, 2}, {0, 2}});
  EXPECT_NEAR(margin(square, {1, 0.5}), 0.5, 1e-15);
  EXPECT_NEAR(margin(square, {3, 1}), -1.0, 1e-15);
  EXPECT_NEAR(margin(square, {5, 6}), -5.0, 1e-15);
  EXPECT_NEAR(margin({{0, 0}, {2, 0}}, {1, 1}), -1.0, 1e-15);
  EXPECT_NEAR(margin({{3, 0}}, {0, 4}), -5.0, 1e-15);
}

TEST(Polygon, HullHoldsEveryPointAndItsCentroid) {
  Random random = Random::stream(3, "polygon");
  for (int i = 0; i < 200; ++i) {
    std::vector<Eigen::Vector2d> points;
    for (std::size_t n = 3 + random.index(30); n > 0; --n)
      points.emplace_back(random.normal(), random.normal());
    const Polygon2 hull = convex_hull(points);
    ASSERT_GE(hull.size(), 3U);
    EXPECT_GT(area(hull), 0.0);
    EXPECT_GT(margin(hull, centroid(hull)), 0.0);
    for (const Eigen::Vector2d& p : points) EXPECT_GT(margin(hull, p), -1e-12);
  }
}

}  // namespace
}  // namespace stonestack::geometry
