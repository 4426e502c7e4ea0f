// Several views of one scene, several copies of one stone, and what a trace keeps.
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "detection/align_views.hpp"
#include "detection/test_scene.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/detection/trace.hpp"

namespace stonestack {
namespace {

constexpr double kDegree = 3.14159265358979 / 180.0;

class Views : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    for (int seed = 1; seed <= 3; ++seed) stones().push_back(test::make_test_stone(seed));
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
  /// Stone 0 behind stone 1, as the first camera sees it; both before the second one.
  static std::vector<DepthView> hidden_scene(const Pose& off) {
    const Pose first = test::make_camera_pose(1.15, 0.0, 0.6), second = test::make_camera_pose(1.0, 1.8, 0.6);
    const std::vector<test::StandingStone> standing = {{&stones()[0], pose(0)}, {&stones()[1], pose(1)}};
    return {{test::with_noise(test::look_at(standing, first), 0.0006, 1), first},
            {test::with_noise(test::look_at(standing, second), 0.0006, 2), second * off}};
  }
  static Pose pose(int stone) {
    const Eigen::Quaterniond upright(Eigen::AngleAxisd(1.45, Eigen::Vector3d::UnitY()));
    return stone == 0 ? test::on_table(stones()[0], Eigen::Quaterniond::Identity(), -0.13, 0.0)
                      : test::on_table(stones()[1], upright, 0.05, 0.0);
  }
  static bool right(const DetectionResult& result, const Pose& T_W_C, int stone) {
    for (const auto& d : result.detections)
      if (d.stone == stone) {
        const auto off = difference(T_W_C * d.T_C_O, pose(stone));
        return off.translation < 0.004 && off.angle < 3 * kDegree;
      }
    return false;
  }
};

TEST_F(Views, ASecondViewFindsWhatTheFirstOneHides) {
  const auto views = hidden_scene(Pose::Identity());
  const auto one = detect_stones(views.front().image, *models());
  const auto two = detect_stones(views, *models());
  EXPECT_FALSE(right(one, views[0].T_W_C, 0)) << "the scene should hide it";
  EXPECT_TRUE(right(two, views[0].T_W_C, 0));
  EXPECT_TRUE(right(two, views[0].T_W_C, 1));
  EXPECT_EQ(two.detections.size(), 2U);
}

TEST_F(Views, AnErrorOfTheCameraPoseIsAlignedAway) {
  const Pose off =
      make_pose({0.0015, -0.001, 0.001}) * Pose(Eigen::AngleAxisd(0.005, Eigen::Vector3d::UnitX()));
  const auto views = hidden_scene(off);
  EXPECT_TRUE(right(detect_stones(views, *models()), views[0].T_W_C, 0));
}

TEST_F(Views, OneViewGivesTheSameAsTheImageAlone) {
  const auto views = hidden_scene(Pose::Identity());
  const auto alone = detect_stones(views[1].image, *models());
  const auto single = detect_stones(std::span(views).subspan(1), *models());
  ASSERT_EQ(alone.detections.size(), single.detections.size());
  ASSERT_FALSE(alone.detections.empty());
  EXPECT_EQ(alone.detections[0].T_C_O.matrix(), single.detections[0].T_C_O.matrix());
  EXPECT_THROW((void)detect_stones(std::span<const DepthView>{}, *models()), InvalidArgument);
}

TEST_F(Views, TwoCopiesOfOneStoneAreBothFoundWhenAskedFor) {
  const Pose T_W_C = test::make_camera_pose(0.4, 0.7);
  const Pose a =
      test::on_table(stones()[2], Eigen::Quaterniond(0.6, 0.3, -0.5, 0.5).normalized(), -0.1, 0.02);
  const Pose b =
      test::on_table(stones()[2], Eigen::Quaterniond(0.1, -0.8, 0.3, 0.4).normalized(), 0.1, -0.03);
  const DepthImage image =
      test::with_noise(test::look_at({{&stones()[2], a}, {&stones()[2], b}}, T_W_C), 0.0006, 3);
  DetectionOptions options;
  EXPECT_EQ(detect_stones(image, *models(), {}, options).detections.size(), 1U);
  options.copies = 2;
  const auto found = detect_stones(image, *models(), {}, options).detections;
  ASSERT_EQ(found.size(), 2U);
  for (const Pose& truth : {a, b})
    EXPECT_TRUE(std::any_of(found.begin(), found.end(), [&](const Detection& d) {
      return d.stone == 2 && difference(T_W_C * d.T_C_O, truth).translation < 0.003;
    }));
}

TEST_F(Views, ATraceHoldsEveryStageAndCanBeWritten) {
  const auto views = hidden_scene(Pose::Identity());
  DetectionOptions options;
  EXPECT_EQ(detect_stones(views[1].image, *models(), {}, options).trace, nullptr);
  options.trace = true;
  options.sweep = false;  // descriptors at once
  const auto result = detect_stones(views[1].image, *models(), {}, options);
  ASSERT_NE(result.trace, nullptr);
  ASSERT_FALSE(result.trace->turns.empty());
  const TracedTurn& turn = result.trace->turns.front();
  EXPECT_GT(turn.surface_C.size(), 1000U);
  EXPECT_EQ(turn.cluster.size(), turn.surface_C.size());
  EXPECT_GT(turn.keypoints_C.size(), 50U);
  EXPECT_EQ(turn.matches.size(), turn.keypoints_C.size() * stones().size());
  EXPECT_FALSE(turn.hypotheses.empty());
  const auto accepted = std::count_if(turn.candidates.begin(), turn.candidates.end(),
                                      [](const TracedCandidate& c) { return c.accepted; });
  EXPECT_EQ(static_cast<std::size_t>(accepted), result.detections.size());
  const auto folder = std::filesystem::temp_directory_path() / ("trace_" + std::to_string(::getpid()));
  write_trace(folder.string(), *result.trace, stones());
  for (const char* name : {"stages.json", "surface.ply", "keypoints.ply", "cluster_0.ply", "candidate_0.ply"})
    EXPECT_TRUE(std::filesystem::exists(folder / "turn_1" / name)) << name;
  EXPECT_NE(read_file((folder / "turn_1/stages.json").string(), 100U << 20U).find("consistency"),
            std::string::npos);
  std::filesystem::remove_all(folder);
}

TEST(AlignViews, FindsASmallMotionAndRefusesALargeOne) {
  const Stone stone = test::make_test_stone(4);
  SurfacePoints surface;
  for (const auto& s : sample_surface(stone.mesh, 0.003)) {
    surface.points.emplace_back(s.point.cast<float>());
    surface.normals.emplace_back(s.normal.cast<float>());
    surface.areas.push_back(0.0F);
  }
  const auto carried = [&](const Pose& T) {
    SurfacePoints out = surface;
    for (auto& p : out.points) p = T.cast<float>() * p;
    for (auto& n : out.normals) n = T.linear().cast<float>() * n;
    return out;
  };
  const Pose small =
      make_pose({0.002, -0.001, 0.0015}) * Pose(Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY()));
  const Pose back = alignment({surface, {}}, {carried(small), {}}, {});
  EXPECT_LT(difference(back * small, Pose::Identity()).translation, 0.0002);
  EXPECT_LT(difference(back * small, Pose::Identity()).angle, 0.1 * kDegree);
  const Pose large = make_pose({0.012, 0.0, 0.0});
  EXPECT_TRUE(alignment({surface, {}}, {carried(large), {}}, {}).isApprox(Pose::Identity()));
}

}  // namespace
}  // namespace stonestack
