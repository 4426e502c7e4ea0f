#include <gtest/gtest.h>

#include <thread>

#include "physics/bodies.hpp"
#include "physics/world.hpp"

/// Rough concave stones: do they come to rest and stay, and is a run the same every time?
namespace stonestack::physics {
namespace {

using test::at;
using test::lump;

/// Lump on lump, dropped from a little above; poses after `seconds`.
World dropped(const std::shared_ptr<const ContactShape>& below,
              const std::shared_ptr<const ContactShape>& above, double seconds) {
  WorldOptions options;
  options.friction = 0.5;
  World world(options);
  world.add_stone(below, at(0, 0, 0.04));
  world.add_stone(above, at(0.004, 0.002, 0.11, 0.7));
  world.run(seconds);
  return world;
}

TEST(Rest, RoughStonesStopAndDoNotCreep) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    World world = dropped(lump(seed), lump(seed + 10), 4.0);
    const Pose early[2] = {world.pose(0), world.pose(1)};
    world.run(10.0);
    for (int i = 0; i < 2; ++i) {
      const auto moved = difference(early[i], world.pose(i));
      EXPECT_LT(moved.translation, 1e-5) << "seed " << seed << ", stone " << i;
      EXPECT_LT(moved.angle, 2e-4) << "seed " << seed << ", stone " << i;
    }
    for (const Contact& c : world.contacts()) EXPECT_GT(c.gap, -1e-4) << "sinks";
  }
}

TEST(Rest, SameBitsAgainAndInEveryThread) {
  const auto below = lump(4), above = lump(5);
  const World alone = dropped(below, above, 1.0);
  std::vector<Pose> found(4, Pose::Identity());
  std::vector<std::thread> threads;
  for (auto& pose : found)
    threads.emplace_back([&pose, &below, &above] { pose = dropped(below, above, 1.0).pose(1); });
  for (auto& thread : threads) thread.join();
  for (const Pose& pose : found) EXPECT_EQ(pose.matrix(), alone.pose(1).matrix());
}

}  // namespace
}  // namespace stonestack::physics
