#include "simulation/scatter.hpp"

#include <gtest/gtest.h>

#include "pebble.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack::simulation {
namespace {

constexpr double kClearance = 0.02;

TrueWorld world_of(int pebbles) {
  std::vector<Stone> stones;
  std::vector<StoneIndex> present;
  for (int i = 0; i < pebbles; ++i) {
    stones.push_back(make_pebble("pebble_" + std::to_string(i + 1), 1.0));
    present.emplace_back(i);
  }
  TrueWorld world(stones, present, make_robotiq_3f(), {});
  GripperPose away;
  away.T_W_T = make_pose(Eigen::Vector3d(0, 0, 100.0));
  world.set_gripper_pose(away);
  return world;
}

std::vector<Eigen::Vector2d> seen_from_above(const TrueWorld& world, StoneIndex stone) {
  std::vector<Eigen::Vector2d> points;
  for (const auto& sample : at(world.shapes(), stone)->samples)
    points.emplace_back((world.pose(stone) * sample.point).head<2>());
  return points;
}

double gap(const std::vector<Eigen::Vector2d>& a, const std::vector<Eigen::Vector2d>& b) {
  double nearest = 1e9;
  for (const auto& p : a)
    for (const auto& q : b) nearest = std::min(nearest, (p - q).norm());
  return nearest;
}

/// A field that three stones just fill: how the first two lie decides whether the third fits. With the
/// seed 6 the third attempt is the first that does.
TEST(Scatter, StartsOverWhereTheLastStoneDoesNotFit) {
  const StoneField field{{0.4, -0.2}, {0.19, 0.17}, kClearance};
  for (const std::uint64_t seed : {5, 6}) {
    TrueWorld world = world_of(3);
    ASSERT_NO_THROW(scatter_stones(world, field, seed)) << "seed " << seed;
    for (const StoneIndex i : first_stones(3)) {
      EXPECT_TRUE(world.rests(i));
      EXPECT_LE(std::abs(world.centre_of_mass(i).x() - 0.4), 0.5 * field.size.x() + 0.002);
      EXPECT_LE(std::abs(world.centre_of_mass(i).y() + 0.2), 0.5 * field.size.y() + 0.002);
      for (const StoneIndex j : first_stones(static_cast<std::size_t>(i.value())))
        EXPECT_GT(gap(seen_from_above(world, i), seen_from_above(world, j)), 0.8 * kClearance);
    }
  }
}

/// A field too full for stones 6 cm apart, as that of the cell is for eight rocks: they lie closer
/// together rather than not at all.
TEST(Scatter, InAFullFieldStonesLieCloserTogether) {
  const StoneField field{{0.4, -0.2}, {0.19, 0.17}, 0.06};
  TrueWorld world = world_of(3);
  ASSERT_NO_THROW(scatter_stones(world, field, 5));
  double nearest = 1.0;
  for (const StoneIndex i : first_stones(3)) {
    EXPECT_TRUE(world.rests(i));
    for (const StoneIndex j : first_stones(static_cast<std::size_t>(i.value())))
      nearest = std::min(nearest, gap(seen_from_above(world, i), seen_from_above(world, j)));
  }
  EXPECT_GT(nearest, 0.004);
  EXPECT_LT(nearest, 0.05);
}

/// The six stones that come along in the cell's field, with seeds whose first field has no free place for the
/// last: the earlier stones must not obstruct those that are dropped anew.
TEST(Scatter, ANewScatterRemovesEarlierStones) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const CellLayout layout;
  for (const int seed : {3, 4, 18}) {
    SimulationOptions options;
    options.seed = seed;
    TrueWorld world(catalogue.stones, first_stones(6), make_robotiq_3f(), options);
    GripperPose away;
    away.T_W_T = make_pose(Eigen::Vector3d(0, 0, 100.0));
    world.set_gripper_pose(away);
    ASSERT_NO_THROW(scatter_stones(world, {layout.field_centre, layout.field_size, options.clearance},
                                   static_cast<std::uint64_t>(seed)))
        << "seed " << seed;
    for (const Contact& contact : world.contacts())
      EXPECT_EQ(contact.below, kTable) << "seed " << seed << ": a stone lies on another";
  }
}

TEST(Scatter, TheSameSeedGivesTheSameField) {
  const StoneField field{{0.0, 0.0}, {0.4, 0.4}, kClearance};
  TrueWorld once = world_of(2), again = world_of(2);
  scatter_stones(once, field, 7);
  scatter_stones(again, field, 7);
  for (const StoneIndex i : first_stones(2)) EXPECT_TRUE(once.pose(i).isApprox(again.pose(i), 0.0));
}

TEST(Scatter, AFieldThatIsTooSmallIsRefusedByName) {
  const StoneField field{{0.0, 0.0}, {0.12, 0.10}, kClearance};
  TrueWorld world = world_of(3);
  try {
    scatter_stones(world, field, 1);
    FAIL() << "three stones of 10 cm in a field of 12 cm";
  } catch (const InvalidArgument& error) {
    EXPECT_NE(std::string(error.what()).find("no free place for stone pebble_"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace stonestack::simulation
