#include <gtest/gtest.h>

#include <algorithm>

#include "detection/test_scene.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::detection {
namespace {

std::ptrdiff_t count(const Explanation& e, PixelEvidence kind) {
  return std::count(e.evidence.begin(), e.evidence.end(), kind);
}

double total(const ScoreLosses& l) {
  return l.misfit + l.seen_through + l.in_front + l.hidden + l.beside + l.outline + l.below + l.bend +
         l.without_depth + l.loose;
}

class Explain : public test::FourOfFive {
 protected:
  static DetectionOptions traced() {
    DetectionOptions options;
    options.trace = true;
    return options;
  }
};

TEST_F(Explain, AStoneThatIsThereIsFoundAndAnAbsentOneRefutedByItsPixels) {
  const Scene scene = make_scene(3);
  const DetectionResult result = detect_stones(scene.image, *models(), {}, traced());
  const Explanation there = explain_stone(scene.image, result, *models(), 1_stone, traced());
  EXPECT_EQ(there.stage, "found");
  ASSERT_TRUE(there.best.has_value());
  EXPECT_GT(count(there, PixelEvidence::kFits), 2000);
  EXPECT_LT(count(there, PixelEvidence::kSeenThrough), count(there, PixelEvidence::kFits) / 10);
  const Explanation absent = explain_stone(scene.image, result, *models(), 4_stone, traced());
  ASSERT_TRUE(absent.best.has_value()) << "something is always like it: " << absent.text;
  EXPECT_EQ(absent.stage, "refuted");
  EXPECT_LT(absent.best->score, absent.wanted);
  EXPECT_NEAR(1.0 - absent.best->score, total(absent.lost), 1e-9);
  EXPECT_NE(absent.text.find("is wanted"), std::string::npos) << absent.text;
}

TEST_F(Explain, AStoneThatIsInTheCatalogueTwiceIsClaimedByItsTwin) {
  const std::vector<Stone> twins{stones()[0], stones()[0]};
  const DetectionModels both(twins);
  const Scene scene = make_scene(5);
  const DetectionResult result = detect_stones(scene.image, both, {}, traced());
  ASSERT_EQ(result.detections.size(), 1U);
  const StoneIndex other = result.detections[0].stone == 0_stone ? 1_stone : 0_stone;
  EXPECT_EQ(explain_stone(scene.image, result, both, other, traced()).stage, "claimed by another");
}

TEST_F(Explain, AStoneThatNobodyAskedForWasNotSearched) {
  const Scene scene = make_scene(3);
  const std::vector<StoneIndex> wanted{1_stone};
  const DetectionResult result = detect_stones(scene.image, *models(), wanted, traced());
  EXPECT_EQ(explain_stone(scene.image, result, *models(), 2_stone, traced()).stage, "not searched");
  EXPECT_EQ(explain_stone(scene.image, result, *models(), 1_stone, traced()).stage, "found");
}

TEST_F(Explain, ADetectionLeftOutForItsDepthScaleSaysSo) {
  Scene scene = make_scene(3);
  for (float& z : scene.image.z) z *= 1.10F;
  const DetectionResult result = detect_stones(scene.image, *models(), {}, traced());
  ASSERT_TRUE(result.detections.empty());
  ASSERT_NE(result.note.find("depth unit"), std::string::npos) << result.note;
  const Explanation e = explain_stone(scene.image, result, *models(), 1_stone, traced());
  EXPECT_EQ(e.stage, "left out") << e.text;
  EXPECT_NE(e.text.find("depth unit"), std::string::npos) << e.text;
}

TEST_F(Explain, AnEmptyTableHasNoSurfaceAndASceneOfSpecksNoHypothesis) {
  const DepthImage empty = test::look_at({}, test::make_camera_pose(0.3, 0.2));
  const DetectionResult nothing = detect_stones(empty, *models(), {}, traced());
  const Explanation none = explain_stone(empty, nothing, *models(), 0_stone, traced());
  EXPECT_EQ(none.stage, "no surface");
  EXPECT_FALSE(none.best.has_value());
  EXPECT_TRUE(none.evidence.empty());
  Stone pebble;
  pebble.mesh = pebble.scan = make_box(Eigen::Vector3d::Constant(0.03));
  const DepthImage small =
      test::look_at({{&pebble, make_pose({0, 0, 0.015})}}, test::make_camera_pose(0.3, 0.2));
  const DetectionResult result = detect_stones(small, *models(), {}, traced());
  const Explanation tiny = explain_stone(small, result, *models(), 0_stone, traced());
  EXPECT_EQ(tiny.stage, "no hypothesis") << tiny.text;
}

TEST_F(Explain, RefusesAResultWithoutATraceAndAModelThatIsNotThere) {
  const Scene scene = make_scene(3);
  const DetectionResult plain = detect_stones(scene.image, *models());
  EXPECT_THROW((void)explain_stone(scene.image, plain, *models(), 0_stone), InvalidArgument);
  const DetectionResult result = detect_stones(scene.image, *models(), {}, traced());
  EXPECT_THROW((void)explain_stone(scene.image, result, *models(), StoneIndex(5), traced()), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::detection
