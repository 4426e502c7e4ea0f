#include "search/held_support.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "box_scenes.hpp"

namespace stonestack::search {
namespace {

/// A box of 8 kg under one of 2 kg, whose middle lies 20 mm beside it; more may stand upon them.
struct HeldBoxes {
  StoneGeometry lower = geometry({0.2, 0.2, 0.1}, 8.0), upper = geometry({0.1, 0.1, 0.05}, 2.0);
  std::vector<BodyPose> bodies = {body(lower, {0, 0, 0.05}), body(upper, {0.02, 0, 0.125})};
  std::vector<PlacedStone> stones = {{0_stone, Pose::Identity()}, {1_stone, Pose::Identity()}};

  void add(const Eigen::Vector3d& p_W) {
    bodies.push_back(body(upper, p_W));
    stones.push_back({2_stone, Pose::Identity()});
  }
  /// Share of 1,000 worlds in which the two tip over.
  [[nodiscard]] double tipped() const {
    int count = 0;
    for (int world = 0; world < 1000; ++world) count += tips_held(bodies, stones, 2, 7, world) ? 1 : 0;
    return count / 1000.0;
  }

 private:
  static StoneGeometry geometry(const Eigen::Vector3d& size, double mass) {
    const Mesh mesh = make_box(size);
    StoneGeometry made;
    made.vertices_M = mesh.vertices;
    made.faces = mesh.faces;
    made.mass = mass;
    made.radius = 0.5 * size.norm();
    return made;
  }
  static BodyPose body(const StoneGeometry& stone, const Eigen::Vector3d& p_W) {
    return {&stone, Eigen::Matrix3d::Identity(), p_W};
  }
};

TEST(HeldSupport, LiesAboutTheCentreOfMassOfWhatItCarries) {
  const HeldBoxes held;
  const std::vector<Interface> list = held_interfaces(held.bodies, 2);
  ASSERT_EQ(list.size(), 2U);
  const Eigen::Vector2d of_both(0.004, 0.0), of_upper(0.02, 0.0);
  EXPECT_NEAR(margin(list[0].rest.polygon_W, of_both), 0.0055, 0.0005);
  EXPECT_NEAR(margin(list[1].rest.polygon_W, of_upper), 0.0055, 0.0005);
  EXPECT_NEAR(list[0].mass_above, 10.0, 1e-9);
  EXPECT_NEAR(list[1].mass_above, 2.0, 1e-9);
  EXPECT_NEAR(list[0].rest.z, 0.0, 1e-12);
  EXPECT_NEAR(list[1].rest.z, 0.1, 1e-12);
}

/// Chance that a lognormal margin, 6 mm in the median, is exceeded.
double exceeded(double shift) {
  return 0.5 * std::erfc(-std::log(shift / 0.006) / 0.7 / std::sqrt(2.0));
}

TEST(HeldSupport, TipsUnderWhatLiesBesideItsMiddle) {
  HeldBoxes alone, centred, near, far;
  centred.add({0.02, 0, 0.175});
  near.add({0.026, 0, 0.175});
  far.add({0.06, 0, 0.175});
  EXPECT_EQ(alone.tipped(), 0.0) << "they stand";
  EXPECT_NEAR(centred.tipped(), exceeded(0.08 / 12 - 0.004), 0.04) << "above the lower one alone";
  EXPECT_NEAR(near.tipped(), 1.0 - (1.0 - exceeded(0.092 / 12 - 0.004)) * (1.0 - exceeded(0.003)), 0.05);
  EXPECT_GT(far.tipped(), 0.9);
}

TEST(HeldSupport, OnlyHeldStonesHaveIt) {
  HeldBoxes boxes;
  boxes.add({0.06, 0, 0.175});
  EXPECT_TRUE(held_interfaces(boxes.bodies, 0).empty());
  EXPECT_FALSE(tips_held(boxes.bodies, boxes.stones, 0, 7, 0));
  const std::vector<Interface> list = interfaces({boxes.bodies, {}, 2});
  ASSERT_EQ(list.size(), 3U);
  EXPECT_NEAR(list[1].rest.z, 0.1, 1e-12);
  EXPECT_NEAR(list[2].rest.z, 0.15, 0.01) << "as its own shape tells";
}

}  // namespace
}  // namespace stonestack::search
