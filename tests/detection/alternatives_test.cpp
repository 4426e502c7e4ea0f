// Stones with ambiguous poses, and the reported alternatives.
#include "detection/judge/alternatives.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "detection/test_scene.hpp"

namespace stonestack::detection {
namespace {

Stone block(const Eigen::Vector3d& size) {
  Stone stone = test::make_test_stone(1);
  stone.name = "block";
  stone.mesh = stone.scan = make_box(size);
  return stone;
}

TEST(Alternatives, ACubeHas23TurnsOntoItselfAnIrregularStoneNone) {
  const auto turns = turns_onto_itself(make_detection_model(block({0.08, 0.08, 0.08})));
  EXPECT_EQ(turns.size(), 23U);
  for (const auto& T : turns)
    EXPECT_TRUE(((T.linear().array().abs() - 0.5).abs() > 0.45).all()) << T.matrix();
  EXPECT_EQ(turns_onto_itself(make_detection_model(block({0.06, 0.09, 0.14}))).size(), 3U) << "a brick";
  EXPECT_TRUE(turns_onto_itself(make_detection_model(test::make_test_stone(1))).empty());
}

TEST(Alternatives, ACubesPoseIsOneOf24AndTheCovarianceShowsIt) {
  const std::vector<Stone> stones{block({0.08, 0.08, 0.08}), test::make_test_stone(2)};
  const DetectionModels models(stones);
  const Pose T_W_C = test::make_camera_pose(0.5, 0.3);
  const auto turned = [](double angle) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
  };
  const auto image =
      test::with_noise(test::look_at({{&stones[0], test::on_table(stones[0], turned(0.4), -0.1, 0.0)},
                                      {&stones[1], test::on_table(stones[1], turned(1.0), 0.12, 0.0)}},
                                     T_W_C),
                       0.001, 1);
  const auto result = detect_stones(image, models);
  ASSERT_EQ(result.detections.size(), 2U) << result.note;
  for (const auto& d : result.detections) {
    const double turn = std::sqrt(d.covariance.bottomRightCorner<3, 3>().trace());
    if (d.stone == 1_stone) {
      EXPECT_EQ(d.certainty, 1.0);
      EXPECT_LT(turn, 0.05);
      continue;
    }
    EXPECT_LT(d.certainty, 0.2);
    EXPECT_GT(d.alternatives.size(), 8U);
    double sum = d.certainty;
    for (const auto& alternative : d.alternatives) sum += alternative.weight;
    EXPECT_NEAR(sum, 1.0, 0.2) << "but for those that hardly count";
    EXPECT_GT(turn, 0.5);
  }
}

/// The block of stone `there`, alone on a table, seen with noise.
DepthImage image_of(const Stone& there, const Pose& T_W_C) {
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()));
  return test::with_noise(test::look_at({{&there, test::on_table(there, turned, 0.0, 0.0)}}, T_W_C), 0.001,
                          1);
}

TEST(Identity, TheUncertaintyBetweenTwoTwinsIsReported) {
  std::vector<Stone> stones{test::make_test_stone(1), test::make_test_stone(1), test::make_test_stone(2)};
  for (auto& p : stones[1].mesh.vertices) p *= 1.004;  // 0.3 mm: below any camera's resolution
  stones[1].name = "twin";
  const DetectionModels models(stones);
  EXPECT_EQ(models.data().rivals, (std::vector<std::vector<StoneIndex>>{{1_stone}, {0_stone}, {}}));
  const auto found = detect_stones(image_of(stones[0], test::make_camera_pose(0.5, 0.3)), models).detections;
  ASSERT_EQ(found.size(), 1U);
  const Detection& d = found[0];
  ASSERT_LT(d.stone, 2_stone);
  EXPECT_LT(d.certainty, 0.9);
  ASSERT_EQ(d.alternatives.size(), 1U);
  EXPECT_EQ(d.alternatives[0].stone, StoneIndex(1 - d.stone.value()));
  EXPECT_NEAR(d.certainty + d.alternatives[0].weight, 1.0, 1e-9);
  EXPECT_LT(difference(d.alternatives[0].T_C_O, d.T_C_O).translation, 0.003) << "at the same place";
  EXPECT_LT(std::sqrt(d.covariance.bottomRightCorner<3, 3>().trace()), 0.05)
      << "of this stone the pose is known";
}

TEST(Identity, AStoneThatIsKnownElsewhereIsNoRival) {
  const std::vector<Stone> stones{test::make_test_stone(1), test::make_test_stone(1)};
  const DetectionModels models(stones);
  const Pose T_W_C = test::make_camera_pose(0.5, 0.3);
  SceneKnowledge known;
  known.stones.push_back({1_stone, T_W_C.inverse() * make_pose({0, 0, 0.4})});  // in the gripper
  const auto found = detect_stones(image_of(stones[0], T_W_C), models, {}, {}, known).detections;
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].stone, 0_stone);
  EXPECT_EQ(found[0].certainty, 1.0);
}

}  // namespace
}  // namespace stonestack::detection
