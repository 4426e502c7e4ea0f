#include "stonestack/detection/detect_stones.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/constants.hpp"
#include "detection/test_scene.hpp"

namespace stonestack::detection {
namespace {

class Track : public test::FourOfFive {};

TEST_F(Track, TracksFromAGuessAndMissesAnAbsentStone) {
  const Scene scene = make_scene(3);
  for (int i = 0; i < 4; ++i) {
    const Pose T_C_O = scene.T_W_C.inverse() * scene.T_W_O[static_cast<std::size_t>(i)];
    const Eigen::Vector3d c = T_C_O.translation();
    const Pose guess = make_pose(c + Eigen::Vector3d(0.007, -0.006, 0.005)) *
                       Pose(Eigen::AngleAxisd(9 * kDegree, Eigen::Vector3d(1, 2, -1).normalized())) *
                       make_pose(-c) * T_C_O;
    const auto tracked = track_stone(scene.image, *models(), StoneIndex(i), guess);
    ASSERT_TRUE(tracked.has_value()) << "stone " << i;
    EXPECT_TRUE(right(*tracked, scene)) << "stone " << i;
    EXPECT_GT(tracked->visible, 0.1);
  }
  const Pose empty_spot = scene.T_W_C.inverse() * make_pose({0.0, 0.3, 0.05});
  EXPECT_FALSE(track_stone(scene.image, *models(), 0_stone, empty_spot).has_value());
}

TEST_F(Track, TrackedStonesAreInPlaceMovedFallenOrUnseen) {
  const Scene scene = make_scene(3);
  const Pose T_C_W = scene.T_W_C.inverse();
  const auto at = [&](int i) { return scene.T_W_O[static_cast<std::size_t>(i)]; };
  const std::vector<KnownStone> expected = {
      {0_stone, T_C_W * at(0)},
      {1_stone, T_C_W * make_pose({0.006, 0.004, 0.0}) * at(1)},  // now 7 mm beside
      {2_stone, T_C_W * make_pose({0.05, 0.02, 0.08}) * at(2)},   // was 8 cm higher
      {4_stone, T_C_W * make_pose({0.0, 0.0, 0.05})},             // is not there any more
  };
  const auto tracked = track_stones(scene.image, *models(), expected).stones;
  using Status = TrackedStone::Status;
  ASSERT_EQ(tracked.size(), 4U);
  EXPECT_EQ(tracked[0].status, Status::kInPlace);
  EXPECT_EQ(tracked[1].status, Status::kMoved);
  EXPECT_NEAR(tracked[1].moved.translation, std::hypot(0.006, 0.004), 0.0015);
  EXPECT_EQ(tracked[2].status, Status::kFallen);
  EXPECT_NEAR(tracked[2].moved.translation, Eigen::Vector3d(0.05, 0.02, 0.08).norm(), 0.002);
  EXPECT_EQ(tracked[3].status, Status::kUnseen);
  EXPECT_FALSE(tracked[3].detection.has_value());
  const std::vector<KnownStone> held = {{2_stone, T_C_W * make_pose({0.0, 0.0, 0.4})}};
  EXPECT_EQ(track_stones(scene.image, *models(), std::span(expected).subspan(2, 1), {}, {held, {}})
                .stones[0]
                .status,
            Status::kUnseen)
      << "a held stone is not searched on the table";
}

TEST_F(Track, AStoneThatFellByLittleIsFallenToo) {
  const Scene scene = make_scene(3);
  const Pose before = scene.T_W_C.inverse() * make_pose({0.0, 0.0, 0.020}) * scene.T_W_O[0];
  const auto tracked =
      track_stones(scene.image, *models(), std::vector<KnownStone>{{0_stone, before}}).stones;
  EXPECT_EQ(tracked[0].status, TrackedStone::Status::kFallen) << to_text(tracked[0].status);
  EXPECT_NEAR(tracked[0].moved.translation, 0.020, 0.001);
}

TEST_F(Track, ACloudInMillimetresIsReported) {
  DepthImage image = make_scene(1).image;
  for (auto& z : image.z) z *= 1000.0F;
  const auto result =
      track_stones(image, *models(), std::vector<KnownStone>{{0_stone, make_pose({0, 0, 0.7})}});
  EXPECT_EQ(result.stones[0].status, TrackedStone::Status::kUnseen);
  EXPECT_THAT(result.note, ::testing::HasSubstr("millimetres"));
}

}  // namespace
}  // namespace stonestack::detection
