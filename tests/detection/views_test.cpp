// Several views of one scene, several copies of one stone, and what a trace keeps.
#include <gtest/gtest.h>

#include <unistd.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/constants.hpp"
#include "detection/scene/align_views.hpp"
#include "detection/test_scene.hpp"
#include "detection/trace.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/geometry/cloud.hpp"

namespace stonestack::detection {
namespace {

class Views : public test::StonesOnce<3> {
 protected:
  /// Stone 0 behind stone 1, as the first camera sees it; both before the second one.
  static std::vector<DepthView> hidden_scene(const Pose& off) {
    const Pose first = test::make_camera_pose(1.15, 0.0, 0.6), second = test::make_camera_pose(1.0, 1.8, 0.6);
    const std::vector<test::StandingStone> standing = {{&stones()[0], pose(0_stone)},
                                                       {&stones()[1], pose(1_stone)}};
    return {{test::with_noise(test::look_at(standing, first), 0.0006, 1), first},
            {test::with_noise(test::look_at(standing, second), 0.0006, 2), second * off}};
  }
  static Pose pose(StoneIndex stone) {
    const Eigen::Quaterniond upright(Eigen::AngleAxisd(1.45, Eigen::Vector3d::UnitY()));
    return stone == 0_stone ? test::on_table(stones()[0], Eigen::Quaterniond::Identity(), -0.13, 0.0)
                            : test::on_table(stones()[1], upright, 0.05, 0.0);
  }
  static bool right(const DetectionResult& result, const Pose& T_W_C, StoneIndex stone) {
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
  EXPECT_FALSE(right(one, views[0].T_W_C, 0_stone)) << "the scene should hide it";
  EXPECT_TRUE(right(two, views[0].T_W_C, 0_stone));
  EXPECT_TRUE(right(two, views[0].T_W_C, 1_stone));
  EXPECT_EQ(two.detections.size(), 2U);
}

TEST_F(Views, AnErrorOfTheCameraPoseIsAlignedAway) {
  const Pose off =
      make_pose({0.0015, -0.001, 0.001}) * Pose(Eigen::AngleAxisd(0.005, Eigen::Vector3d::UnitX()));
  const auto views = hidden_scene(off);
  EXPECT_TRUE(right(detect_stones(views, *models()), views[0].T_W_C, 0_stone));
}

TEST_F(Views, TheFusedPosesUncertaintyIsTrue) {
  const Pose off =
      make_pose({0.001, 0.0012, -0.001}) * Pose(Eigen::AngleAxisd(0.004, Eigen::Vector3d::UnitZ()));
  const auto views = hidden_scene(off);
  const auto found = detect_stones(views, *models()).detections;
  ASSERT_EQ(found.size(), 2U);
  for (const auto& d : found) {
    const Pose T_C_O = views[0].T_W_C.inverse() * pose(d.stone);
    const Eigen::AngleAxisd turn(T_C_O.linear() * d.T_C_O.linear().transpose());
    Eigen::Matrix<double, 6, 1> e;
    e << T_C_O.translation() - d.T_C_O.translation(), turn.angle() * turn.axis();
    EXPECT_LT(e.head<3>().norm(), 0.0008) << "stone " << d.stone;
    EXPECT_LT(e.dot(d.covariance.ldlt().solve(e)), 22.5) << "beyond 99.9 %";  // chi^2, six degrees
    EXPECT_LT(std::sqrt(d.covariance.topLeftCorner<3, 3>().trace()), 0.002) << "as good as no statement";
  }
}

TEST(FusedViews, AverageNoErrorOfTheModelOut) {
  Stone small = test::make_test_stone(1);  // its points in two views are fewer than a joint refinement takes
  for (Mesh* mesh : {&small.mesh, &small.scan})
    for (Eigen::Vector3d& p : mesh->vertices) p *= 0.6;
  const DetectionModels models(std::vector<Stone>{small});
  const Pose T_W_C = test::make_camera_pose(0.5, 0.3, 0.5);
  const Pose T_W_O = test::on_table(small, Eigen::Quaterniond(0.7, 0.2, -0.4, 0.5).normalized(), 0, 0);
  const DepthImage clean = test::look_at({{&small, T_W_O}}, T_W_C);
  const std::vector<DepthView> views = {{test::with_noise(clean, 0.0006, 1), T_W_C},
                                        {test::with_noise(clean, 0.0006, 2), T_W_C}};
  const auto one = detect_stones(std::span(views).first(1), models).detections;
  const auto two = detect_stones(views, models).detections;
  ASSERT_EQ(one.size(), 1U);
  ASSERT_EQ(two.size(), 1U);
  // The error of the model, most of it all, is alike in both: only the noise averages out.
  for (const int block : {0, 3}) {
    const auto stated = [&](const Detection& d) { return d.covariance.block<3, 3>(block, block).trace(); };
    EXPECT_GT(stated(two[0]), 0.8 * stated(one[0])) << (block == 0 ? "m^2" : "rad^2");
    EXPECT_LT(stated(two[0]), 1.1 * stated(one[0])) << (block == 0 ? "m^2" : "rad^2");
  }
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

/// Two copies of stone 2, apart.
struct Copies {
  Pose T_W_C = test::make_camera_pose(0.4, 0.7);
  Pose a, b;
  DepthImage image;
  explicit Copies(const Stone& stone)
      : a(test::on_table(stone, Eigen::Quaterniond(0.6, 0.3, -0.5, 0.5).normalized(), -0.1, 0.02)),
        b(test::on_table(stone, Eigen::Quaterniond(0.1, -0.8, 0.3, 0.4).normalized(), 0.1, -0.03)),
        image(test::with_noise(test::look_at({{&stone, a}, {&stone, b}}, T_W_C), 0.0006, 3)) {}
};

TEST_F(Views, TwoCopiesOfOneStoneAreBothFoundWhenAskedFor) {
  const Copies scene(stones()[2]);
  DetectionOptions options;
  EXPECT_EQ(detect_stones(scene.image, *models(), {}, options).detections.size(), 1U);
  options.copies = 2;
  const auto found = detect_stones(scene.image, *models(), {}, options).detections;
  ASSERT_EQ(found.size(), 2U);
  for (const Pose& truth : {scene.a, scene.b})
    EXPECT_TRUE(std::any_of(found.begin(), found.end(), [&](const Detection& d) {
      return d.stone == 2_stone && difference(scene.T_W_C * d.T_C_O, truth).translation < 0.003;
    }));
  EXPECT_EQ(
      detect_stones(scene.image, *models(), std::vector<StoneIndex>{2_stone, 2_stone}).detections.size(), 2U)
      << "named twice";
}

TEST_F(Views, CopiesAreTrackedAsOftenAsTheyAreExpected) {
  const Copies scene(stones()[2]);
  const Pose T_C_W = scene.T_W_C.inverse(), elsewhere = make_pose({0.0, 0.1, 0.06}) * scene.b;
  using Status = TrackedStone::Status;
  const std::vector<KnownStone> both = {{2_stone, T_C_W * scene.a}, {2_stone, T_C_W * elsewhere}};
  const auto tracked = track_stones(scene.image, *models(), both).stones;
  ASSERT_EQ(tracked.size(), 2U);
  EXPECT_EQ(tracked[0].status, Status::kInPlace);
  EXPECT_EQ(tracked[1].status, Status::kFallen) << "it must be searched though another copy is in place";
  DetectionOptions options;
  options.copies = 2;
  const std::vector<KnownStone> one = {{2_stone, T_C_W * make_pose({0.3, 0.3, 0.3})}};
  const auto more = track_stones(scene.image, *models(), one, options).stones;
  ASSERT_EQ(more.size(), 1U);
  EXPECT_TRUE(more[0].detection.has_value()) << "of two that are there, one is the missing one";
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
  for (const char* name : {"stages.json", "surface.ply", "keypoints.ply", "cluster_0.ply", "candidate_0.ply",
                           "matches.ply", "hypotheses.ply"})
    EXPECT_TRUE(std::filesystem::exists(folder / "turn_1" / name)) << name;
  EXPECT_NE(read_file((folder / "turn_1/stages.json").string(), 100U << 20U).find("consistency"),
            std::string::npos);
  const Cloud middles = read_cloud((folder / "turn_1/hypotheses.ply").string());
  ASSERT_EQ(middles.points.size(), turn.hypotheses.size());
  const TracedHypothesis& h = turn.hypotheses.front();
  const Eigen::Vector3d middle = bounds(at(stones(), h.stone).mesh).center();
  EXPECT_LT((middles.points.front().cast<double>() - h.T_C_O * middle).norm(), 1e-5);
  std::filesystem::remove_all(folder);
}

TEST(AlignViews, TheTableCorrectsHeightAndTiltAndTheReportHoldsTheRest) {
  const Pose first = test::make_camera_pose(0.6, 0.0), second = test::make_camera_pose(0.9, 2.0);
  const auto plane_of = [](const Pose& T_W_C) {
    const Eigen::Vector3d normal = T_W_C.linear().transpose() * Eigen::Vector3d::UnitZ();
    return Plane{normal, -T_W_C.translation().z()};
  };
  const Pose off = make_pose({0.001, -0.0015, 0.002}) *
                   Pose(Eigen::AngleAxisd(0.006, Eigen::Vector3d(1, -2, 1).normalized()));
  SeenView view;
  view.T_C_V_reported = first.inverse() * second * off;
  view.table_V = plane_of(second);
  view.error.count.assign(1, 100000);
  const Pose aligned = aligned_view(plane_of(first), view);
  const auto table_off = [&](const Pose& T_C_V) {
    double worst = 0;
    for (const Eigen::Vector3d& p_W :
         {Eigen::Vector3d(0.2, 0.1, 0), Eigen::Vector3d(-0.2, 0.1, 0), Eigen::Vector3d(0, -0.2, 0)})
      worst = std::max(worst, std::abs(plane_of(first).distance(T_C_V * (second.inverse() * p_W))));
    return worst;
  };
  EXPECT_GT(table_off(view.T_C_V_reported), 0.0015);
  EXPECT_LT(table_off(aligned), 0.0004);
  EXPECT_LT(difference(aligned, view.T_C_V_reported).angle, 0.0061) << "further than the report can be off";
  const Pose blind = aligned_view({}, view);
  EXPECT_LT(difference(blind, view.T_C_V_reported).translation, 1e-12) << "nothing to go by";
}

}  // namespace
}  // namespace stonestack::detection
