#include <gtest/gtest.h>

#include <algorithm>

#include "rooms.hpp"
#include "stacking/arrangement.hpp"
#include "stacking/unknown_objects.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"
#include "unknown_pile.hpp"

namespace stonestack::stacking {
namespace {

/// A run that takes nothing but the first look at two stones and `foreign` objects.
struct FirstLook {
  Catalogue catalogue = read_catalogue(data_path("stones"));
  RobotModel robot = read_robot("ur10");
  simulation::SimulatedCell world;
  RunResult result;

  explicit FirstLook(int foreign)
      : world(catalogue.stones, first_stones(2), robot, CellLayout{}, with_foreign(foreign)) {
    Cell cell = world.cell();
    BuildOptions options;
    options.max_stones = 1;
    options.search.horizon = 1;
    result = build_tower(cell, catalogue, robot, options);
  }
  static simulation::SimulationOptions with_foreign(int count) {
    simulation::SimulationOptions options;
    options.seed = 5;
    options.foreign_objects = count;
    options.clearance = 0.02;
    return options;
  }
};

TEST(UnknownObjects, AreSeenWhereTheyLie) {
  const FirstLook look(2);
  const auto seen = all_of<UnknownObjectSeen>(look.result.events);
  ASSERT_EQ(seen.size(), 2U);
  const auto truth = look.world.truth();
  for (std::size_t k = look.catalogue.stones.size(); k < truth.T_W_O.size(); ++k) {
    const Eigen::Vector2d p_W = truth.T_W_O[k].translation().head<2>();
    double nearest = 1.0;
    for (const UnknownObjectSeen& object : seen) nearest = std::min(nearest, (object.p_W - p_W).norm());
    EXPECT_LT(nearest, 0.012) << p_W.transpose();
  }
  for (const UnknownObjectSeen& object : seen) {
    EXPECT_GT(object.highest, 0.02);
    EXPECT_LT(object.highest, 0.15);
  }
}

/// True where something unknown at the site is kept clear of.
bool is_kept_clear(const WorldEstimate& world) {
  const auto& obstacles = world.layout.obstacles;
  return std::any_of(obstacles.begin(), obstacles.end(),
                     [&](const Obstacle& object) { return ground_of(object).contains(world.layout.site); });
}

TEST(UnknownObjects, AtTheSiteAreInTheWayWhereNoTowerStands) {
  stonestack::test::UnknownPile pile({2_stone});
  EXPECT_TRUE(is_kept_clear(pile.observed()));
}

/// Sets the depth about the pixel that shows a place.
void cover(CameraView& view, const Eigen::Vector3d& p_W, float z) {
  constexpr int kAround = 8;  // pixels
  const CameraIntrinsics& camera = view.image.camera;
  const Eigen::Vector3d p_C = view.T_W_C.inverse() * p_W;
  if (!(p_C.z() > 0.0)) return;
  const Eigen::Vector2i pixel = project(camera, p_C).array().round().cast<int>();
  for (int v = std::max(0, pixel.y() - kAround); v < std::min(camera.height, pixel.y() + kAround); ++v)
    for (int u = std::max(0, pixel.x() - kAround); u < std::min(camera.width, pixel.x() + kAround); ++u)
      view.image.z[static_cast<std::size_t>(v * camera.width + u)] = z;
}

TEST(UnknownObjects, AreInTheWayUntilAViewShowsThatTheyAreGone) {
  stonestack::test::UnknownPile pile({2_stone});
  const WorldEstimate world = pile.observed();
  ASSERT_TRUE(is_kept_clear(world));
  const auto out_of_sight = unknown_objects(pile.workcell, {}, world);
  ASSERT_EQ(out_of_sight.size(), world.layout.obstacles.size());
  const auto at_site = [&](const UnknownThing& thing) {
    return ground_of(obstacle_about(thing, "it")).contains(world.layout.site);
  };
  EXPECT_TRUE(std::any_of(out_of_sight.begin(), out_of_sight.end(), at_site));
  for (const float z : {0.0F, 0.3F}) {  // no depth is measured there; something stands before the camera
    Views hidden = *world.views;
    for (CameraView& view : hidden)
      for (const UnknownThing& thing : out_of_sight)
        for (const Eigen::Vector3d& p_W : thing.surface_W) cover(view, p_W, z);
    const auto behind = unknown_objects(pile.workcell, hidden, world);
    EXPECT_TRUE(std::any_of(behind.begin(), behind.end(), at_site)) << z;
  }
  pile.take_away();
  EXPECT_FALSE(is_kept_clear(pile.observed()));
}

TEST(UnknownObjects, OnATowerAreInTheWay) {
  stonestack::test::UnknownPile pile({1_stone, 2_stone});
  const WorldEstimate world = pile.observed(as_estimates({{0_stone, pile.T_W_lower}}));
  ASSERT_EQ(world.stack.size(), 1U) << "nobody has touched it";
  EXPECT_TRUE(is_kept_clear(world));
  stonestack::test::UnknownPile all({1_stone, 2_stone, 3_stone});
  const WorldEstimate tower =
      all.observed(as_estimates({{0_stone, all.T_W_lower}, {2_stone, all.T_W_upper}}));
  EXPECT_EQ(tower.stack.size(), 2U);
  EXPECT_FALSE(is_kept_clear(tower)) << "it is the tower";
}

TEST(UnknownObjects, AreTakenForNoStoneLater) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const ShapeList shapes = make_contact_shapes(catalogue.stones);
  Obstacle box;
  box.pieces = {make_box({0.08, 0.06, 0.05})};
  box.T_W_O = Eigen::Translation3d(0.5, -0.1, 0.025);
  const auto sighting = [&](StoneIndex stone, double x) {
    const Eigen::Vector3d p_O_M = com_of(shapes, {stone, Pose::Identity()});
    return Sighting{stone, Pose(Eigen::Translation3d(Eigen::Vector3d(x, -0.1, 0.03) - p_O_M)), 0.9, 0.3, 1.0};
  };
  std::vector<Sighting> seen{sighting(0_stone, 0.52), sighting(1_stone, 0.52), sighting(2_stone, 0.70)};
  drop_known_objects(shapes, {0_stone}, {&box, 1}, seen);
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_EQ(seen[0].stone, 0_stone) << "a stone that is known may have fallen there";
  EXPECT_EQ(seen[1].stone, 2_stone) << "nothing lay there";
}

TEST(UnknownObjects, StonesAreNone) {
  const FirstLook look(0);
  EXPECT_EQ(look.result.height, 1) << look.result.ended;
  EXPECT_TRUE(all_of<UnknownObjectSeen>(look.result.events).empty());
}

}  // namespace
}  // namespace stonestack::stacking
