#include "physics/world.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "physics/bodies.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::physics {
namespace {

using test::at;
using test::box;

WorldOptions with_friction(double friction, int iterations = 50) {
  WorldOptions options;
  options.friction = friction;
  options.iterations = iterations;
  return options;
}

TEST(World, FallsFreely) {
  World world;
  const int stone = world.add_stone(box(0.06, 0.05, 0.04), at(0, 0, 1.0));
  world.run(0.25);
  const double steps = 0.25 / world.options().step;  // symplectic Euler: g t^2 (1 + 1 / steps) / 2
  EXPECT_NEAR(world.pose(stone).translation().z(), 1.0 - 0.5 * 9.81 * 0.0625 * (1 + 1 / steps), 1e-9);
  EXPECT_NEAR(world.twist(stone).v.z(), -9.81 * 0.25, 1e-9);
  EXPECT_NEAR(world.time(), 0.25, 1e-9);
}

/// How far a block slides in 2 s on a plane tilted by `share` of atan(friction), in a direction that is
/// neither the block's nor an axis of the world.
double slid(double friction, double yaw, double share) {
  World world(with_friction(friction));
  const int block = world.add_stone(box(0.06, 0.06, 0.03), at(0, 0, 0.015, yaw));
  const double tilt = std::atan(friction) * share;
  world.set_gravity(9.81 * Eigen::Vector3d(std::sin(tilt) * std::cos(0.6), std::sin(tilt) * std::sin(0.6),
                                           -std::cos(tilt)));
  world.run(2.0);
  return world.pose(block).translation().head<2>().norm();
}

TEST(World, BlockSlidesAtTheFrictionAngleInEveryDirection) {
  for (const double friction : {0.1, 0.5})
    for (const double yaw : {0.0, 0.4, 0.785}) {
      EXPECT_LT(slid(friction, yaw, 0.98), 1e-4) << "friction " << friction << ", yaw " << yaw;
      const double tilt = std::atan(friction) * 1.02;
      const double expected = 2.0 * 9.81 * (std::sin(tilt) - friction * std::cos(tilt));
      EXPECT_NEAR(slid(friction, yaw, 1.02), expected, 0.02 * expected)
          << "friction " << friction << ", yaw " << yaw;
    }
}

TEST(World, CubesStandWithoutCreeping) {
  World world(with_friction(0.1));
  const auto cube = box(0.06, 0.06, 0.06);
  for (int i = 0; i < 3; ++i) world.add_stone(cube, at(0.003 * i, 0, 0.03 + 0.06 * i, 0.3 * i));
  world.run(1.0);
  std::vector<Pose> early;
  for (int i = 0; i < 3; ++i) early.push_back(world.pose(i));
  world.run(9.0);
  for (int i = 0; i < 3; ++i) {
    const auto moved = difference(early[static_cast<std::size_t>(i)], world.pose(i));
    EXPECT_LT(moved.translation, 1e-6) << "cube " << i;
    EXPECT_LT(moved.angle, 1e-4) << "cube " << i;
    EXPECT_LT(world.kinetic_energy(i), 1e-12) << "cube " << i;
  }
}

TEST(World, ImpulsesCarryTheWeight) {
  World world;
  const auto cube = box(0.06, 0.06, 0.06);
  world.add_stone(cube, at(0, 0, 0.03));
  world.add_stone(cube, at(0.01, 0.005, 0.09));
  world.run(1.0);
  const double weight = cube->mass.mass * 9.81 * world.options().step;
  double on_table = 0.0, on_cube = 0.0;
  for (const Contact& c : world.contacts()) {
    (c.below == kTable ? on_table : on_cube) += c.impulse * c.n_W.z();
    EXPECT_GT(c.n_W.z(), 0.99) << "normals point from below to above";
  }
  EXPECT_NEAR(on_table, 2 * weight, 1e-3 * weight);
  EXPECT_NEAR(on_cube, weight, 1e-3 * weight);
}

/// Share of four cubes that the table carries in the very first step, when nothing is known of the impulses
/// yet: 1 for all of their weight.
double carried_at_once(int iterations) {
  WorldOptions options;
  options.iterations = iterations;
  World world(options);
  const auto cube = box(0.06, 0.06, 0.06);
  for (int i = 0; i < 4; ++i) world.add_stone(cube, at(0.004 * i, 0, 0.03 + 0.06 * i));
  world.step();
  double on_table = 0.0;
  for (const Contact& c : world.contacts())
    if (c.below == kTable) on_table += c.impulse * c.n_W.z();
  return on_table / (4 * cube->mass.mass * 9.81 * options.step);
}

TEST(World, RefreshesTheContactsAsOftenAsConfigured) {
  EXPECT_LT(carried_at_once(10), 0.9);
  EXPECT_NEAR(carried_at_once(2000), 1.0, 1e-3);
}

TEST(World, BoxPushesAStoneAndFixedStonesStay) {
  World world;
  const int stone = world.add_stone(box(0.06, 0.06, 0.06), at(0, 0, 0.03));
  const int fixed = world.add_stone(box(0.06, 0.06, 0.06), at(0, 0.2, 0.5), true);
  const int pusher = world.add_box({0.02, 0.1, 0.04}, at(-0.041, 0, 0.03));
  for (int i = 1; i <= 240; ++i) {
    world.move_to(pusher, at(-0.041 + 0.05 * i / 240.0, 0, 0.03));
    world.step();
  }
  EXPECT_NEAR(world.pose(stone).translation().x(), 0.049, 2e-4);
  EXPECT_LT(difference(world.pose(fixed), at(0, 0.2, 0.5)).translation, 1e-12);
  world.set_fixed(fixed, false);
  world.run(0.1);
  EXPECT_LT(world.pose(fixed).translation().z(), 0.46);
}

TEST(World, AStoneDeeperThanTheDistanceFieldComesOut) {
  World world;
  world.set_gravity(Eigen::Vector3d::Zero());
  world.add_stone(box(0.1, 0.1, 0.1), at(0, 0, 0), true);
  const int thrown = world.add_stone(box(0.03, 0.03, 0.05), at(0.01, 0.005, 0.05));  // 25 mm deep
  for (int i = 0; i < 240; ++i) {
    world.step();
    ASSERT_TRUE(world.pose(thrown).matrix().allFinite()) << "step " << i;
  }
  EXPECT_GT(world.pose(thrown).translation().z(), 0.07);
}

TEST(World, ContactCanBeTurnedOffAndFrictionSetForAPair) {
  World world(with_friction(0.1));
  const int stone = world.add_stone(box(0.06, 0.06, 0.06), at(0, 0, 0.03));
  world.set_pair_friction(stone, kTable, 0.8);
  world.set_gravity({3.0, 0, -9.81});
  world.run(1.0);
  EXPECT_LT(world.pose(stone).translation().x(), 1e-3);
  world.set_contact(stone, kTable, false);
  world.run(0.2);
  EXPECT_LT(world.pose(stone).translation().z(), 0.0);
}

TEST(World, ForcesActForOneStep) {
  World world;
  const auto shape = box(0.06, 0.06, 0.06);
  const int stone = world.add_stone(shape, at(0, 0, 1.0));
  for (int i = 0; i < 100; ++i) {
    world.apply(stone, {0, 0, 9.81 * shape->mass.mass});
    world.step(1.0 / 960.0);
  }
  EXPECT_NEAR(world.pose(stone).translation().z(), 1.0, 1e-9);
  world.step();
  EXPECT_LT(world.twist(stone).v.z(), -0.04);
}

TEST(World, RefusesWhatCannotBe) {
  World world;
  const int box_index = world.add_box({0.1, 0.1, 0.1}, at(0, 0, 1));
  const int stone = world.add_stone(box(0.06, 0.06, 0.06), at(0, 0, 0.03));
  EXPECT_THROW(static_cast<void>(world.pose(7)), InvalidArgument);
  EXPECT_THROW(world.move_to(stone, at(0, 0, 1)), InvalidArgument);
  EXPECT_THROW(world.set_fixed(box_index, false), InvalidArgument);
  EXPECT_THROW(world.step(0.0), InvalidArgument);
  EXPECT_THROW(World(with_friction(std::nan(""))), InvalidArgument);
  EXPECT_THROW(world.add_box({0.1, 0, 0.1}, at(0, 0, 1)), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::physics
