#include "search/landing.hpp"

#include <gtest/gtest.h>

#include "search_scenes.hpp"

namespace stonestack::search {
namespace {

constexpr double kLandingCell = 0.004;

StackField field_of(const std::vector<BodyPose>& stack, double clean_height = 0.006) {
  return {top_surface(stack, {{0, 0}, kLandingCell, 70}, clean_height), interfaces({stack, {}}), 0.1};
}

LandingGrid land_box(const StackField& field, const Mesh& box, int i, int j) {
  UndersideOptions options;
  options.cell = kLandingCell;
  options.stride = field.surface.heights.stride;
  GapField buffer;
  return land(field, make_underside(box.vertices, box.faces, Eigen::Matrix3d::Identity(), options), 1.0,
              {i, j, 2, 2}, &buffer);
}

TEST(Interfaces, CubeOnTheTableTipsAtHalfWidthOverHeight) {
  const StoneGeometry cube = geometry_of(make_box({0.1, 0.1, 0.1}), 2.0);
  const std::vector<BodyPose> stack = {at(cube, 0, 0, 0.05)};
  const std::vector<Interface> list = interfaces({stack, {}});
  ASSERT_EQ(list.size(), 1U);
  EXPECT_NEAR(list[0].rest.z, 0.0, 1e-9);
  EXPECT_NEAR(area(list[0].rest.polygon_W), 0.01, 0.001);  // hull of nodes 3 mm apart
  // A second cube on top: centre of mass 0.1 m up, 0.05 m from the rim.
  EXPECT_NEAR(tipping_limit(list, 2.0, {0, 0, 0.15}), 0.5, 0.03);
  // Set 40 mm aside, the pair's centre moves by 20 mm.
  EXPECT_NEAR(tipping_limit(list, 2.0, {0.04, 0, 0.15}), 0.3, 0.03);
}

TEST(Landing, FlatOnFlatBearsItsFriction) {
  const StoneGeometry base = geometry_of(make_box({0.2, 0.2, 0.1}));
  const LandingGrid grid = land_box(field_of({at(base, 0, 0, 0.05)}), make_box({0.1, 0.1, 0.06}), 0, 0);
  const Landing& landing = grid.at(0, 0);
  ASSERT_TRUE(landing.holds);
  EXPECT_NEAR(landing.height, 0.13, 1e-5);
  EXPECT_NEAR(landing.slope, 0.0, 1e-3);
  EXPECT_NEAR(landing.estimate, 0.1, 1e-3);
}

TEST(Landing, TiltedSupportCostsItsSlope) {
  StoneGeometry wedge = geometry_of(make_box({0.3, 0.3, 0.1}));
  for (Eigen::Vector3d& v : wedge.vertices_M)
    if (v.z() > 0) v.z() += 0.06 * v.x();
  const LandingGrid grid = land_box(field_of({at(wedge, 0, 0, 0.05)}), make_box({0.1, 0.1, 0.06}), 0, 0);
  ASSERT_TRUE(grid.at(0, 0).holds);
  EXPECT_NEAR(grid.at(0, 0).slope, -0.06, 2e-3);
  EXPECT_NEAR(grid.at(0, 0).estimate, 0.04, 2e-3);
}

TEST(Landing, StoneThatWouldTouchALowerStoneDoesNotHold) {
  const StoneGeometry base = geometry_of(make_box({0.3, 0.3, 0.1})),
                      slab = geometry_of(make_box({0.1, 0.1, 0.02}));
  const StoneGeometry thin = geometry_of(make_box({0.1, 0.1, 0.004}));
  const Mesh plate = make_box({0.24, 0.24, 0.04});
  EXPECT_TRUE(land_box(field_of({at(base, 0, 0, 0.05), at(slab, 0, 0, 0.11)}), plate, 0, 0).at(0, 0).holds);
  EXPECT_FALSE(land_box(field_of({at(base, 0, 0, 0.05), at(thin, 0, 0, 0.102)}), plate, 0, 0).at(0, 0).holds);
}

TEST(Landing, LeaningOnTheTableDoesNotHold) {
  const StoneGeometry base = geometry_of(make_box({0.06, 0.06, 0.012}));
  const Mesh plate = make_box({0.2, 0.1, 0.02});
  EXPECT_FALSE(land_box(field_of({at(base, 0, 0, 0.006)}), plate, 10, 0).at(0, 0).holds);
}

}  // namespace
}  // namespace stonestack::search
