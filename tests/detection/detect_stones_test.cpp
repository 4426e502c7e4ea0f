#include "stonestack/detection/detect_stones.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <limits>
#include <set>

#include "detection/test_scene.hpp"
#include "detection/trace.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::detection {
namespace {

class Detect : public test::FourOfFive {};

TEST_F(Detect, FindsTheStonesThatAreThereAndNoOther) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Scene scene = make_scene(seed);
    for (const auto& d : detect_stones(scene.image, *models()).detections) {
      ASSERT_LT(d.stone, 4_stone) << "stone 4 is not there, seed " << seed;
      EXPECT_TRUE(right(d, scene)) << "stone " << d.stone << ", seed " << seed << ", score " << d.score;
      ++found;
    }
  }
  EXPECT_GE(found, 12 - 1);
}

TEST_F(Detect, SearchesOnlyForTheWantedStones) {
  const Scene scene = make_scene(1);
  const std::vector<StoneIndex> wanted = {2_stone};
  const auto result = detect_stones(scene.image, *models(), wanted);
  ASSERT_EQ(result.detections.size(), 1U);
  EXPECT_EQ(result.detections[0].stone, 2_stone);
  EXPECT_TRUE(right(result.detections[0], scene));
}

TEST_F(Detect, LeavesOutWhatIsKnown) {
  const Scene scene = make_scene(1);
  SceneKnowledge known;
  for (int i = 0; i < 4; ++i)
    known.stones.push_back({StoneIndex(i), scene.T_W_C.inverse() * scene.T_W_O[static_cast<std::size_t>(i)]});
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

TEST_F(Detect, StonesBeforeAWallAreStillFoundOnTheTable) {
  const Pose T_W_C = test::make_camera_pose(0.6, 0.0);
  const Pose T_W_O =
      test::on_table(stones()[1], Eigen::Quaterniond(0.3, 0.8, -0.4, 0.3).normalized(), 0.05, 0.05);
  RayScene world;
  world.add(make_box({1.6, 1.6, 0.02}), make_pose({0, 0, -0.01}));
  world.add(make_box({0.02, 1.6, 0.8}), make_pose({-0.25, 0, 0.4}));
  world.add(stones()[1].scan, T_W_O);
  world.commit();
  const auto found = detect_stones(render(world, {}, T_W_C).depth, *models()).detections;
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].stone, 1_stone);
  EXPECT_LT(difference(T_W_C * found[0].T_C_O, T_W_O).translation, 0.002);
}

TEST_F(Detect, WithoutATableStonesAreRightOrNotSeen) {
  const Scene scene = make_scene(2);
  DepthImage cut = scene.image;
  const CameraIntrinsics& camera = cut.camera;
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u)
      if (float& z = cut.z[static_cast<std::size_t>(v * camera.width + u)];
          z > 0 && (scene.T_W_C * (z * deproject(camera, u, v))).z() < 0.008)
        z = 0;
  for (const auto& d : detect_stones(cut, *models()).detections)
    EXPECT_TRUE(right(d, scene)) << "stone " << d.stone << ", score " << d.score;
}

TEST_F(Detect, LensDistortionIsCorrected) {
  const Pose T_W_C = test::make_camera_pose(0.4, 0.9);
  const Pose T_W_O =
      test::on_table(stones()[3], Eigen::Quaterniond(0.2, -0.7, 0.5, 0.4).normalized(), 0.17, 0.12);
  using Distortion = CameraIntrinsics::Distortion;
  for (const Distortion kind : {Distortion::kBrownConrady, Distortion::kInverseBrownConrady}) {
    CameraIntrinsics camera;
    camera.distortion = kind;
    const double k[5] = {0.30, -0.25, 0.002, -0.001, 0.04};
    std::copy(std::begin(k), std::end(k), camera.k);
    DepthImage image = test::look_at({{&stones()[3], T_W_O}}, T_W_C, camera);
    const auto off = [&] {
      const auto found = detect_stones(image, *models()).detections;
      return found.size() == 1 && found[0].stone == 3_stone
                 ? difference(T_W_C * found[0].T_C_O, T_W_O).translation
                 : 1.0;
    };
    EXPECT_LT(off(), 0.001);
    image.camera.distortion = Distortion::kNone;
    EXPECT_GT(off(), 0.002) << "the lens of this test does nothing";
  }
}

TEST_F(Detect, PaperModeSearchesOnceWithItsOwnDescriptorAndNoSweep) {
  const std::vector<Stone> two(stones().begin(), stones().begin() + 2);
  const auto matches = [&](const std::string& descriptor, const std::string& keypoints) {
    DetectionOptions options = options_of("paper");
    EXPECT_EQ(options.descriptor, "rops");
    EXPECT_EQ(options.matching, "kdtree");
    options.trace = true;
    options.descriptor = descriptor;
    options.keypoints = keypoints;
    const auto result = detect_stones(make_scene(1).image, DetectionModels(two, options), {}, options);
    std::set<float> distances;
    if (result.trace == nullptr || result.trace->turns.size() != 1U) return distances;
    const TracedTurn& turn = result.trace->turns[0];
    EXPECT_FALSE(turn.keypoints_C.empty()) << descriptor;
    EXPECT_TRUE(keypoints == "iss" || !turn.hypotheses.empty()) << descriptor;
    for (const auto& h : turn.hypotheses) EXPECT_EQ(h.source, "consistency") << descriptor;
    for (const auto& m : turn.matches) distances.insert(m.distance);
    return distances;
  };
  std::set<std::set<float>> all;
  for (const char* descriptor : {"rops", "iss", "shot"}) all.insert(matches(descriptor, "voxel"));
  EXPECT_EQ(all.size(), 3U) << "each descriptor is a choice";
  EXPECT_TRUE(all.insert(matches("shot", "iss")).second) << "and so are the keypoints";
  EXPECT_EQ(all.count({}), 0U) << "searches once";
}

TEST_F(Detect, AMirroredSceneShowsNoStone) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Scene scene = make_scene(seed);
    DepthImage mirrored = scene.image;
    const int width = mirrored.camera.width;
    for (int v = 0; v < mirrored.camera.height; ++v)
      std::reverse(mirrored.z.begin() + v * width, mirrored.z.begin() + (v + 1) * width);
    for (const auto& d : detect_stones(mirrored, *models()).detections)
      ADD_FAILURE() << "stone " << d.stone << " with score " << d.score << ", seed " << seed;
  }
}

TEST_F(Detect, AStoneOutsideTheFrameIsNotSeenAndOneAtItsEdgeIsRightOrNotSeen) {
  const Pose T_W_C = test::make_camera_pose(0.3, 0.0);
  const auto seen_at = [&](double x) {
    const Pose T_W_O =
        test::on_table(stones()[0], Eigen::Quaterniond(0.7, 0.1, 0.3, -0.6).normalized(), 0.0, x);
    const auto found = detect_stones(test::look_at({{&stones()[0], T_W_O}}, T_W_C), *models()).detections;
    for (const auto& d : found) {
      EXPECT_EQ(d.stone, 0_stone) << "at " << x;
      EXPECT_LT(difference(T_W_C * d.T_C_O, T_W_O).translation, 0.005) << "at " << x;
    }
    return !found.empty();
  };
  EXPECT_TRUE(seen_at(0.0));
  EXPECT_FALSE(seen_at(0.8));
  for (const double x : {0.40, 0.44, 0.48, 0.52}) (void)seen_at(x);
}

TEST_F(Detect, AMillionOrTenPointsAreOneImage) {
  const Scene scene = make_scene(2);
  const Cloud one = without_gaps(to_cloud(scene.image));
  Cloud many;
  Random random = Random::stream(1, "ten million points");
  while (many.points.size() < 10'000'000)
    for (const auto& p : one.points) {
      const auto jitter = static_cast<float>(random.uniform(0.9997, 1.0003));
      many.points.emplace_back(jitter * p);
    }
  const auto found = detect_stones(to_depth_image(many, scene.image.camera), *models()).detections;
  EXPECT_GE(found.size(), 3U);
  for (const auto& d : found) EXPECT_TRUE(right(d, scene)) << "stone " << d.stone;
}

TEST_F(Detect, ACloudInMillimetresIsReported) {
  Cloud cloud = to_cloud(make_scene(1).image);
  for (auto& p : cloud.points) p *= 1000.0F;
  const auto result = detect_stones(to_depth_image(cloud, CameraIntrinsics{}), *models());
  EXPECT_TRUE(result.detections.empty());
  EXPECT_THAT(result.note, ::testing::HasSubstr("millimetres"));
}

TEST_F(Detect, ADepthRangeThatIsNoneIsTheCallersFault) {
  DetectionOptions options;
  options.nearest = 0.9, options.farthest = 0.5;
  EXPECT_THROW((void)detect_stones(make_scene(1).image, *models(), {}, options), InvalidArgument);
}

TEST_F(Detect, AHeldStoneIsNotSearchedOnTheTable) {
  const Scene scene = make_scene(1);
  SceneKnowledge known;
  known.stones.push_back(
      {1_stone, scene.T_W_C.inverse() * make_pose({0.0, 0.0, 0.4})});  // in the gripper, above
  for (const auto& d : detect_stones(scene.image, *models(), {}, {}, known).detections)
    EXPECT_NE(d.stone, 1_stone);
}

TEST_F(Detect, AModelThatDoesNotExistIsTheCallersFault) {
  const std::vector<StoneIndex> wanted = {17_stone};
  EXPECT_THROW((void)detect_stones(DepthImage{}, *models(), wanted), InvalidArgument);
  EXPECT_THROW((void)track_stone({}, *models(), kNoStone, Pose::Identity()), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::detection
