#include "benchmarks/span_check.hpp"

#include <gtest/gtest.h>

#include "physics/shape.hpp"

namespace stonestack::bench {
namespace {

/// A box of 120 x 70 x 50 mm with its middle at (x, 0, z).
SpanCheck of_box_at(double x, double z, const Span& span) {
  const Mesh mesh = make_box({0.12, 0.07, 0.05});
  const ShapeList shapes = {make_contact_shape(mesh, mass_properties(mesh, 2600.0), "box")};
  const Stack stack{{{0_stone, make_pose(Eigen::Vector3d(x, 0.0, z))}}};
  return check_span(shapes, stack, Pose::Identity(), span);
}

TEST(SpanCheck, CountsWhatLiesOverTheAxisAndWhatStandsInTheGap) {
  const Span span{-0.05, 0.05, 0.03};
  EXPECT_EQ(of_box_at(0.0, 0.1, span).covered, 1.0);
  EXPECT_EQ(of_box_at(0.0, 0.1, span).in_the_way, 0.0);
  EXPECT_NEAR(of_box_at(0.06, 0.1, span).covered, 0.5, 0.011);
  EXPECT_EQ(of_box_at(0.2, 0.1, span).covered, 0.0);
  EXPECT_NEAR(of_box_at(0.06, 0.025, {-0.05, 0.05, 0.03}).in_the_way, 0.03, 1e-9);
  EXPECT_EQ(of_box_at(0.115, 0.025, span).in_the_way, 0.0) << "beside the gap";
}

TEST(SpanCheck, SeesAStoneInTheGapThatHasNoCornerThere) {
  EXPECT_NEAR(of_box_at(0.0, 0.025, {-0.05, 0.05, 0.03}).in_the_way, 0.03, 1e-9) << "corners at 60 mm";
}

TEST(SpanCheck, OnlyStonesThatStandOnBothSidesBridge) {
  const auto shape = [](const Eigen::Vector3d& size) {
    const Mesh mesh = make_box(size);
    return make_contact_shape(mesh, mass_properties(mesh, 2600.0), "box");
  };
  const ShapeList shapes = {shape({0.1, 0.1, 0.1}), shape({0.1, 0.1, 0.1}), shape({0.2, 0.06, 0.04})};
  const auto at_place = [](int stone, double x, double z) {
    return PlacedStone{StoneIndex(stone), make_pose(Eigen::Vector3d(x, 0.0, z))};
  };
  const Span span{-0.05, 0.05, 0.03};
  const Stack bridge{{at_place(0, -0.1, 0.05), at_place(1, 0.1, 0.05), at_place(2, 0.0, 0.12)}};
  EXPECT_EQ(bridging_stones(shapes, bridge, Pose::Identity(), span).stones.size(), 3U);
  const Stack hanging{{at_place(0, -0.1, 0.05), at_place(1, 0.25, 0.05), at_place(2, 0.0, 0.12)}};
  EXPECT_TRUE(bridging_stones(shapes, hanging, Pose::Identity(), span).stones.empty());
}

}  // namespace
}  // namespace stonestack::bench
