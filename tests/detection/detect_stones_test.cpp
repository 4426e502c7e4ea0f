#include "stonestack/detection/detect_stones.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>

#include "detection/test_scene.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack {
namespace {

constexpr double kDegree = 3.14159265358979 / 180.0;

/// Five test stones; the last is never in a scene.
class Detect : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    for (int seed = 1; seed <= 5; ++seed) stones().push_back(test::make_test_stone(seed));
    models() = std::make_unique<DetectionModels>(stones());
  }
  static void TearDownTestSuite() { models().reset(); }
  static std::vector<Stone>& stones() {
    static std::vector<Stone> all;
    return all;
  }
  static std::unique_ptr<DetectionModels>& models() {
    static std::unique_ptr<DetectionModels> all;
    return all;
  }

  /// Stones 0 to 3 apart on the table, in random orientations.
  struct Scene {
    Pose T_W_C;
    std::vector<Pose> T_W_O;
    DepthImage image;
  };
  static Scene make_scene(std::uint64_t seed) {
    Random random = Random::stream(seed, "scene");
    Scene scene;
    scene.T_W_C = test::make_camera_pose(random.uniform(0.0, 0.7), random.uniform(0.0, 6.28));
    std::vector<test::StandingStone> standing;
    for (int i = 0; i < 4; ++i) {
      const auto& stone = stones()[static_cast<std::size_t>(i)];
      scene.T_W_O.push_back(
          test::on_table(stone, random.rotation(), i % 2 == 0 ? -0.11 : 0.11, i < 2 ? -0.11 : 0.11));
      standing.push_back({&stone, scene.T_W_O.back()});
    }
    scene.image = test::with_noise(test::look_at(standing, scene.T_W_C), 0.001, seed);
    return scene;
  }
  static bool right(const Detection& d, const Scene& scene) {
    const PoseDifference error =
        difference(d.T_C_O, scene.T_W_C.inverse() * scene.T_W_O[static_cast<std::size_t>(d.stone)]);
    return error.translation < 0.005 && error.angle < 5 * kDegree;
  }
};

TEST_F(Detect, FindsTheStonesThatAreThereAndNoOther) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Scene scene = make_scene(seed);
    for (const auto& d : detect_stones(scene.image, *models()).detections) {
      ASSERT_LT(d.stone, 4) << "stone 4 is not there, seed " << seed;
      EXPECT_TRUE(right(d, scene)) << "stone " << d.stone << ", seed " << seed << ", score " << d.score;
      ++found;
    }
  }
  EXPECT_GE(found, 12 - 1);
}

TEST_F(Detect, LooksOnlyForWhatIsWanted) {
  const Scene scene = make_scene(1);
  const std::vector<int> wanted = {2};
  const auto result = detect_stones(scene.image, *models(), wanted);
  ASSERT_EQ(result.detections.size(), 1U);
  EXPECT_EQ(result.detections[0].stone, 2);
  EXPECT_TRUE(right(result.detections[0], scene));
}

TEST_F(Detect, LeavesOutWhatIsKnown) {
  const Scene scene = make_scene(1);
  SceneKnowledge known;
  for (int i = 0; i < 4; ++i)
    known.stones.push_back({i, scene.T_W_C.inverse() * scene.T_W_O[static_cast<std::size_t>(i)]});
  EXPECT_TRUE(detect_stones(scene.image, *models(), {}, {}, known).detections.empty());
}

TEST_F(Detect, SameResultForAnyNumberOfThreads) {
  const Scene scene = make_scene(2);
  const auto many = detect_stones(scene.image, *models());
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto few = detect_stones(scene.image, *models());
  ASSERT_EQ(many.detections.size(), few.detections.size());
  for (std::size_t i = 0; i < many.detections.size(); ++i) {
    EXPECT_EQ(many.detections[i].stone, few.detections[i].stone);
    EXPECT_EQ(many.detections[i].T_C_O.matrix(), few.detections[i].T_C_O.matrix());
    EXPECT_EQ(many.detections[i].score, few.detections[i].score);
  }
}

TEST_F(Detect, TracksFromAGuessAndMissesAnAbsentStone) {
  const Scene scene = make_scene(3);
  for (int i = 0; i < 4; ++i) {
    const Pose T_C_O = scene.T_W_C.inverse() * scene.T_W_O[static_cast<std::size_t>(i)];
    const Eigen::Vector3d c = T_C_O.translation();
    const Pose guess = make_pose(c + Eigen::Vector3d(0.007, -0.006, 0.005)) *
                       Pose(Eigen::AngleAxisd(9 * kDegree, Eigen::Vector3d(1, 2, -1).normalized())) *
                       make_pose(-c) * T_C_O;
    const auto tracked = track_stone(scene.image, *models(), i, guess);
    ASSERT_TRUE(tracked.has_value()) << "stone " << i;
    EXPECT_TRUE(right(*tracked, scene)) << "stone " << i;
    EXPECT_GT(tracked->visible, 0.1);
  }
  const Pose empty_spot = scene.T_W_C.inverse() * make_pose({0.0, 0.3, 0.05});
  EXPECT_FALSE(track_stone(scene.image, *models(), 0, empty_spot).has_value());
}

TEST_F(Detect, SenselessImagesGiveANoteAndNothingElse) {
  const auto note_of = [&](const DepthImage& image) {
    const auto result = detect_stones(image, *models());
    EXPECT_TRUE(result.detections.empty());
    return result.note;
  };
  const CameraIntrinsics camera;
  const auto filled = [&](float z) { return DepthImage{camera, std::vector<float>(640UL * 480UL, z)}; };
  EXPECT_NE(note_of({}), "");
  EXPECT_NE(note_of(filled(0.0F)), "");
  EXPECT_NE(note_of(filled(std::numeric_limits<float>::quiet_NaN())), "");
  EXPECT_NE(note_of(filled(std::numeric_limits<float>::infinity())), "");
  EXPECT_NE(note_of(filled(-1.0F)), "");
  EXPECT_NE(note_of(filled(0.7F)), "") << "a table alone";
  EXPECT_NE(note_of({camera, std::vector<float>(7, 0.7F)}), "") << "too few depths";
  DepthImage one = filled(0.0F);
  one.z[240 * 640 + 320] = 0.7F;
  EXPECT_NE(note_of(one), "");
  CameraIntrinsics tiny;
  tiny.width = tiny.height = 3;
  EXPECT_NE(note_of({tiny, std::vector<float>(9, 0.7F)}), "");
  EXPECT_THAT(note_of(filled(700.0F)), ::testing::HasSubstr("millimetres"));
}

TEST_F(Detect, TwoPlanesWithoutStones) {
  const Pose T_W_C = test::make_camera_pose(0.6, 0.0);
  RayScene scene;
  scene.add(make_box({1.6, 1.6, 0.02}), make_pose({0, 0, -0.01}));
  scene.add(make_box({0.02, 1.6, 0.8}), make_pose({-0.2, 0, 0.4}));
  scene.commit();
  EXPECT_TRUE(detect_stones(render(scene, {}, T_W_C).depth, *models()).detections.empty());
}

TEST_F(Detect, AModelThatDoesNotExistIsTheCallersFault) {
  const std::vector<int> wanted = {17};
  EXPECT_THROW((void)detect_stones({}, *models(), wanted), InvalidArgument);
  EXPECT_THROW((void)track_stone({}, *models(), -1, Pose::Identity()), InvalidArgument);
}

}  // namespace
}  // namespace stonestack
