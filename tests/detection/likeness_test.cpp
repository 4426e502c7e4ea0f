// Stones that look like themselves turned, and what is said of their poses.
#include "detection/likeness.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "detection/test_scene.hpp"

namespace stonestack {
namespace {

Stone block(const Eigen::Vector3d& size) {
  Stone stone = test::make_test_stone(1);
  stone.name = "block";
  stone.mesh = stone.scan = make_box(size);
  return stone;
}

TEST(Likeness, ACubeHas23TurnsOntoItselfAnIrregularStoneNone) {
  const auto turns = turns_onto_itself(make_detection_model(block({0.08, 0.08, 0.08}), {}));
  EXPECT_EQ(turns.size(), 23U);
  for (const auto& T : turns)
    EXPECT_TRUE(((T.linear().array().abs() - 0.5).abs() > 0.45).all()) << T.matrix();
  EXPECT_EQ(turns_onto_itself(make_detection_model(block({0.06, 0.09, 0.14}), {})).size(), 3U) << "a brick";
  EXPECT_TRUE(turns_onto_itself(make_detection_model(test::make_test_stone(1), {})).empty());
}

TEST(Likeness, ACubesPoseIsOneOf24AndTheCovarianceSaysSo) {
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
    if (d.stone == 1) {
      EXPECT_EQ(d.certainty, 1.0);
      EXPECT_LT(turn, 0.05);
      continue;
    }
    EXPECT_LT(d.certainty, 0.2);
    EXPECT_GT(d.likes.size(), 8U);
    double sum = d.certainty;
    for (const auto& like : d.likes) sum += like.weight;
    EXPECT_NEAR(sum, 1.0, 0.2) << "but for those that hardly count";
    EXPECT_GT(turn, 0.5);
  }
}

}  // namespace
}  // namespace stonestack
