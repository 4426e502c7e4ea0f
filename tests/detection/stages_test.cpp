#include <gtest/gtest.h>

#include <cmath>

#include "core/constants.hpp"
#include "detection/features/consistency.hpp"
#include "detection/features/keypoints.hpp"
#include "detection/features/matching.hpp"
#include "detection/features/models.hpp"
#include "detection/hypotheses/candidates.hpp"
#include "detection/hypotheses/refine.hpp"
#include "detection/judge/accept.hpp"
#include "detection/judge/contour.hpp"
#include "detection/judge/draw_model.hpp"
#include "detection/judge/verify.hpp"
#include "detection/scene/preprocess.hpp"
#include "detection/test_scene.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::detection {
namespace {

SurfacePoints cube_surface(double size, double spacing) {
  SurfacePoints out;
  for (const auto& s : sample_surface(make_box(Eigen::Vector3d::Constant(size)), spacing)) {
    out.points.emplace_back(s.point.cast<float>());
    out.normals.emplace_back(s.normal.cast<float>());
    out.areas.push_back(static_cast<float>(s.area));
  }
  return out;
}

TEST(Preprocess, FindsTheTableAndOneClusterAStone) {
  const Stone a = test::make_test_stone(1), b = test::make_test_stone(2);
  const Pose T_W_C = test::make_camera_pose(0.4, 0.3);
  const DepthImage image =
      test::with_noise(test::look_at({{&a, test::on_table(a, Eigen::Quaterniond::Identity(), -0.12, 0.0)},
                                      {&b, test::on_table(b, Eigen::Quaterniond::Identity(), 0.12, 0.05)}},
                                     T_W_C),
                       0.0008, 1);
  const DetectionScene scene = preprocess(image, {}, true, {});
  ASSERT_TRUE(scene.table_C.has_value());
  const Eigen::Vector3d up_C = T_W_C.linear().transpose() * Eigen::Vector3d::UnitZ();
  EXPECT_LT(std::acos(scene.table_C->normal.dot(up_C)), 0.2 * kDegree);
  EXPECT_NEAR(scene.table_C->distance(T_W_C.inverse() * Eigen::Vector3d::Zero()), 0.0, 0.0005);
  EXPECT_EQ(scene.clusters, 2);
}

TEST(SurfaceField, GivesSamplesThatAreHardlyFurtherThanTheNearest) {
  const SurfacePoints cube = cube_surface(0.08, 0.003);
  const SurfaceField field(cube.points, 0.003F, 0.020F);
  Random random = Random::stream(1, "surface field");
  double further = 0.0;
  int within = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto place = [&] { return static_cast<float>(random.uniform(-0.062, 0.062)); };
    const Eigen::Vector3f p(place(), place(), place());
    float nearest = 1.0F;
    for (const auto& q : cube.points) nearest = std::min(nearest, (p - q).norm());
    const int k = field.nearest(p);
    if (nearest > 0.023F) {
      EXPECT_EQ(k, -1);
    }
    if (nearest > 0.017F) continue;
    ASSERT_GE(k, 0) << nearest;
    const float off = (p - cube.points[static_cast<std::size_t>(k)]).norm() - nearest;
    EXPECT_LT(off, 0.0053F) << "two half diagonals of a cell";
    further += off;
    ++within;
  }
  EXPECT_GT(within, 1000);
  EXPECT_LT(further / within, 0.0005);
}

TEST(Keypoints, VoxelKeypointsAreApartAndCover) {
  const SurfacePoints cube = cube_surface(0.1, 0.003);
  const auto keypoints = voxel_keypoints(cube, 0.010F);
  EXPECT_GT(keypoints.size(), 400U);  // 600 squares of 1 cm^2 on the cube, some cells hold an edge
  EXPECT_LT(keypoints.size(), 1000U);
}

TEST(Keypoints, IssFindsTheCornersOfACube) {
  const double size = 0.1;
  const SurfacePoints cube = cube_surface(size, 0.003);
  const auto keypoints = iss_keypoints(cube);
  ASSERT_FALSE(keypoints.empty());
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3f at =
        static_cast<float>(0.5 * size) *
        Eigen::Vector3f((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1);
    float nearest = 1.0F;
    for (const int i : keypoints)
      nearest = std::min(nearest, (cube.points[static_cast<std::size_t>(i)] - at).norm());
    EXPECT_LT(nearest, 0.012F) << "corner " << corner;
  }
  EXPECT_LT(keypoints.size(), cube.points.size() / 50) << "hardly any point is one";
  for (const int i : keypoints) {
    const Eigen::Vector3f p = cube.points[static_cast<std::size_t>(i)].cwiseAbs();
    const auto at_edge = (p.array() > static_cast<float>(0.5 * size) - 0.012F).count();
    EXPECT_GE(at_edge, 2) << "within a face, at " << p.transpose();
  }
}

/// Scene features at T_C_O of model features, one to one.
struct FeatureSet {
  Features model, scene;
  std::vector<Correspondence> matches;
};

FeatureSet make_feature_set(const Pose& T_C_O, bool mirror) {
  FeatureSet set;
  Random random = Random::stream(3, "features");
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector3d n = random.unit_vector(), p = n.cwiseProduct(Eigen::Vector3d(0.08, 0.06, 0.04));
    const Eigen::Vector3d flip(1, 1, mirror ? -1 : 1);
    set.model.points.emplace_back(p.cast<float>());
    set.model.normals.emplace_back(n.cast<float>());
    set.scene.points.emplace_back((T_C_O * p.cwiseProduct(flip)).cast<float>());
    set.scene.normals.emplace_back((T_C_O.linear() * n.cwiseProduct(flip)).cast<float>());
    set.matches.push_back({i, i, 0.01F * static_cast<float>(i)});
  }
  return set;
}

TEST(Consistency, FindsTheRigidMotionAmongWrongMatches) {
  const Pose T_C_O = make_pose({0.1, -0.2, 0.7}, Eigen::Quaterniond(0.5, 0.1, -0.7, 0.3));
  FeatureSet set = make_feature_set(T_C_O, false);
  Random random = Random::stream(4, "wrong");
  for (int i = 0; i < 60; ++i)
    set.matches.push_back({static_cast<int>(random.index(30)), static_cast<int>(random.index(30)), 0.5F});
  const auto found = consistent_groups(set.matches, set.scene, set.model, {});
  ASSERT_FALSE(found.empty());
  EXPECT_LT(difference(found[0].T_C_O, T_C_O).angle, 1.0 * kDegree);
  EXPECT_LT(difference(found[0].T_C_O, T_C_O).translation, 0.001);
}

TEST(Consistency, RejectsAMirroredSet) {
  const Pose T_C_O = make_pose({0, 0, 0.7});
  const FeatureSet as_it_is = make_feature_set(T_C_O, false), mirrored = make_feature_set(T_C_O, true);
  const auto found = consistent_groups(as_it_is.matches, as_it_is.scene, as_it_is.model, {});
  ASSERT_FALSE(found.empty());
  EXPECT_GE(found[0].support, 15) << "otherwise nothing is shown by what follows";
  EXPECT_TRUE(consistent_groups(mirrored.matches, mirrored.scene, mirrored.model, {}).empty())
      << "all distances agree, no rigid motion does";
}

class OneStone : public ::testing::Test {
 protected:
  Stone stone = test::make_test_stone(5);
  DetectionOptions options;
  DetectionModel model = make_detection_model(stone);
  Pose T_W_C = test::make_camera_pose(0.5, 1.0);
  Pose T_W_O = test::on_table(stone, Eigen::Quaterniond(Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitZ())),
                              0.02, -0.01);
  Pose T_C_O = T_W_C.inverse() * T_W_O;
  DetectionScene scene = preprocess(test::look_at({{&stone, T_W_O}}, T_W_C), {}, true, options);
};

TEST_F(OneStone, RefinementConvergesFrom8MillimetresAnd8Degrees) {
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d unit = Eigen::Vector3d::Unit(axis);
    const Eigen::Vector3d c = T_C_O.translation();
    const Pose start = make_pose(0.008 * Eigen::Vector3d::Unit((axis + 1) % 3) + c) *
                       Pose(Eigen::AngleAxisd(8 * kDegree, unit)) * make_pose(-c) * T_C_O;
    const auto near = points_near(model, start, scene.surface, 0.015, 3000);
    RefineOptions refine;
    refine.iterations = 25;
    const Refined refined = refine_pose(model, start, scene.surface, near, refine);
    EXPECT_LT(difference(refined.T_C_O, T_C_O).translation, 0.0005) << "axis " << axis;
    EXPECT_LT(difference(refined.T_C_O, T_C_O).angle, 0.5 * kDegree) << "axis " << axis;
  }
}

TEST_F(OneStone, VerdictAcceptsTheTruthAndRejectsPosesBehindAndAboveTheTable) {
  const auto score = [&](const Pose& T) { return verify_pose(model, T, scene, {}).score; };
  EXPECT_GT(score(T_C_O), 0.95);
  const Eigen::Vector3d up_C = scene.table_C->normal;
  EXPECT_LT(score(make_pose(-0.12 * up_C) * T_C_O), 0.3) << "behind the table";
  EXPECT_LT(score(make_pose(0.05 * up_C) * T_C_O), 0.3) << "in the air";
  EXPECT_LT(score(make_pose({0.25, 0, 0}) * T_C_O), 0.3) << "beside the stone";
  EXPECT_LT(score(make_pose({0, 0, 0.03}) * T_C_O), 0.5) << "further down the line of sight";
}

TEST_F(OneStone, VerdictIsEmptyOutsideTheImage) {
  EXPECT_LT(verify_pose(model, make_pose({3, 0, 0.7}), scene, {}).score, 0);
  EXPECT_LT(verify_pose(model, make_pose({0, 0, -0.7}), scene, {}).score, 0);
}

Stone make_slab(const Eigen::Vector3d& size) {
  Stone slab;
  slab.name = "slab";
  slab.mesh = slab.scan = make_box(size);
  return slab;
}

TEST(Verify, AFlatStoneThatFitsIntoTheFaceOfALargerOneIsRefutedByItsOutline) {
  const Stone large = make_slab({0.16, 0.12, 0.02}), small = make_slab({0.09, 0.07, 0.02});
  const Pose T_W_C = test::make_camera_pose(0.3, 0.5), T_W_O = make_pose({0, 0, 0.01});
  const DepthImage image = test::with_noise(test::look_at({{&large, T_W_O}}, T_W_C), 0.0006, 1);
  const DetectionOptions options;
  const DetectionScene scene = preprocess(image, {}, true, options);
  const auto verdict = [&](const Stone& stone) {
    VerifyOptions strict;
    strict.contour = true;
    return verify_pose(make_detection_model(stone), T_W_C.inverse() * T_W_O, scene, strict);
  };
  const Verdict of_small = verdict(small);
  const double without_outline = of_small.score + of_small.lost.outline + of_small.lost.bend;
  EXPECT_GT(without_outline, options.accept_score) << "the trap is gone: no pixel contradicts the small one";
  EXPECT_GT(of_small.lost.outline, without_outline - 0.5);
  EXPECT_GT(of_small.lost.bend, 0.1) << "its sides are drawn where the face is seen";
  EXPECT_LT(of_small.score, 0.5);
  EXPECT_GT(verdict(large).score, 0.95);
}

TEST(Verify, ThingsInFrontHaveOutlinesOfTheirOwn) {
  const Stone flat = make_slab({0.16, 0.12, 0.03}), board = make_slab({0.30, 0.05, 0.004});
  const Pose T_W_C = test::make_camera_pose(0.3, 0.5), T_W_O = make_pose({0, 0, 0.015});
  const Pose T_W_board = make_pose({0, 0.03, 0.10});
  const DetectionOptions options;
  const DetectionScene scene =
      preprocess(test::look_at({{&flat, T_W_O}, {&board, T_W_board}}, T_W_C), {}, true, options);
  const DetectionModel model = make_detection_model(flat);
  const DrawnModel drawn =
      draw_model(model.drawn, model.drawn_normals, T_W_C.inverse() * T_W_O, scene.views[0].depth.camera, 2);
  const ContourTally contour = compare_contour(scene.views[0], drawn, 0.02);
  EXPECT_GT(contour.seen, 100);
  EXPECT_LT(contour.goes_on, 0.02 * contour.seen)
      << "the board goes on across the outline, the stone does not";
}

TEST(Verify, NormalsOfADrawnModelAreThoseOfItsFacesAndReachOverRipples) {
  const CameraIntrinsics camera;
  const Pose T = make_pose({0, 0, 0.7}, Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitY())));
  const Mesh plain = make_box({0.12, 0.12, 0.02});
  const DrawnModel drawn = draw_model(plain, face_normals(plain), T, camera, 2);
  const Eigen::Vector3d towards = T.linear() * -Eigen::Vector3d::UnitZ();
  EXPECT_LT((drawn_normal(drawn, camera, drawn.width / 2, drawn.height / 2) - towards).norm(), 1e-3);
  Mesh rippled;  // 1.5 mm long and 0.4 mm high: up to 28 deg off the plane
  const auto add_strip = [&](double x0, double z0, double x1, double z1) {
    const int first = static_cast<int>(rippled.vertices.size());
    for (const auto& [x, z] : {std::pair(x0, z0), std::pair(x1, z1)})
      for (const double y : {-0.06, 0.06}) rippled.vertices.emplace_back(x, y, z);
    rippled.faces.emplace_back(first, first + 1, first + 2);
    rippled.faces.emplace_back(first + 1, first + 3, first + 2);
  };
  for (int i = -40; i < 40; ++i) {
    add_strip(0.0015 * i, 0.0, 0.0015 * (i + 0.5), 0.0004);
    add_strip(0.0015 * (i + 0.5), 0.0004, 0.0015 * (i + 1), 0.0);
  }
  const auto faces = face_normals(rippled);
  const DrawnModel ripples = draw_model(rippled, faces, T, camera, 2);
  double of_faces = 0, of_drawn = 0;
  int count = 0;
  for (int y = ripples.height / 4; y < 3 * ripples.height / 4; ++y)
    for (int x = ripples.width / 4; x < 3 * ripples.width / 4; ++x) {
      const auto i = static_cast<std::size_t>(y * ripples.width + x);
      if (!(ripples.z[i] > 0)) continue;
      of_faces += (ripples.normals_C[static_cast<std::size_t>(ripples.face[i])] - towards).norm();
      of_drawn += (drawn_normal(ripples, camera, x, y) - towards).norm();
      ++count;
    }
  ASSERT_GT(count, 200);
  EXPECT_GT(of_faces / count, 0.3);
  EXPECT_LT(of_drawn / count, 0.1);
}

TEST(Candidates, EveryPoseOfANearlySymmetricStoneIsJudgedFinely) {
  Stone cube = make_slab(Eigen::Vector3d::Constant(0.1));
  for (auto& p : cube.mesh.vertices)
    if (p.minCoeff() > 0) p *= 0.92;  // one corner of eight, on top and towards the camera
  cube.scan = cube.mesh;
  const Pose T_W_C = test::make_camera_pose(0.5, 0.7), T_W_O = make_pose({0, 0, 0.05});
  const DetectionOptions options;
  const DetectionScene scene =
      preprocess(test::with_noise(test::look_at({{&cube, T_W_O}}, T_W_C), 0.0006, 1), {}, true, options);
  std::vector<Hypothesis> turned;
  for (const Eigen::Vector3d& axis : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0)})
    for (int side = 0; side < 4; ++side)
      for (int turn = 0; turn < 4; ++turn)
        turned.push_back({T_W_C.inverse() * T_W_O * Eigen::AngleAxisd(side * M_PI_2, axis) *
                              Eigen::AngleAxisd(turn * M_PI_2, Eigen::Vector3d::UnitZ()),
                          1.0});
  const auto judged = judge_hypotheses(make_detection_model(cube), 0_stone, turned, scene, options);
  EXPECT_GT(judged.size(), 5U);
  ASSERT_FALSE(judged.empty());
  const Eigen::Vector3d corner = Eigen::Vector3d::Constant(0.046);  // about its diagonal all turns are alike
  EXPECT_LT((judged.front().detection.T_C_O * corner - T_W_C.inverse() * T_W_O * corner).norm(), 0.004);
}

/// An image of which every pixel has a depth.
DetectionScene filled_scene() {
  DetectionScene scene;
  auto& depth = scene.views.emplace_back().depth;
  depth.z.assign(static_cast<std::size_t>(depth.camera.width * depth.camera.height), 0.7F);
  return scene;
}

/// A pose that explains a square of `side` image pixels from (u0, v0) on, drawn at every `step`-th.
Candidate square_candidate(StoneIndex stone, double score, int side, int step, int u0 = 100, int v0 = 100) {
  Candidate c;
  c.detection.stone = stone, c.detection.score = score, c.detection.visible = 0.4;
  for (int v = v0; v < v0 + side; ++v)
    for (int u = u0; u < u0 + side; ++u)
      if (u % step == 0 && v % step == 0) c.pixels.push_back({0, 640 * v + u, step});
  return c;
}

TEST(Accept, KeepsTheMoreCompleteOfTwoPosesAtOnePlace) {
  const DetectionScene scene = filled_scene();
  const auto taken =
      without_conflicts({square_candidate(0_stone, 0.96, 40, 1), square_candidate(1_stone, 0.995, 37, 1)},
                        {0_stone, 1_stone}, scene, {}, Demand::kLikely);
  ASSERT_EQ(taken.size(), 1U);
  EXPECT_EQ(taken[0], 1U) << "a wrong flat stone covered more of the right one's face";
  EXPECT_EQ(
      without_conflicts({square_candidate(0_stone, 0.96, 40, 1), square_candidate(1_stone, 0.99, 11, 1)},
                        {0_stone, 1_stone}, scene, {}, Demand::kLikely)[0],
      0U)
      << "a speck that fits is no evidence";
}

TEST(Accept, ALargeStoneDrawnCoarselyCountsAsMuchAsASmallOneDrawnFinely) {
  const auto taken =
      without_conflicts({square_candidate(0_stone, 0.994, 80, 2), square_candidate(1_stone, 0.991, 70, 1)},
                        first_stones(2), filled_scene(), {}, Demand::kLikely);
  ASSERT_EQ(taken.size(), 1U);
  EXPECT_EQ(taken[0], 0U) << "it fits better and explains more";
}

TEST(Accept, OnePlaceIsOneStoneWhateverTheStepsOfDrawing) {
  for (const int step : {1, 3, 5, 6, 16})
    for (const int other : {1, 4, 5, 6, 15})
      EXPECT_EQ(without_conflicts(
                    {square_candidate(0_stone, 0.99, 240, step), square_candidate(1_stone, 0.98, 240, other)},
                    first_stones(2), filled_scene(), {}, Demand::kLikely)
                    .size(),
                1U)
          << "steps " << step << ", " << other;
  EXPECT_EQ(
      without_conflicts({square_candidate(0_stone, 0.99, 96, 6), square_candidate(1_stone, 0.98, 96, 5, 200)},
                        first_stones(2), filled_scene(), {}, Demand::kLikely)
          .size(),
      2U)
      << "side by side";
}

TEST_F(OneStone, IsNotTwoStones) {
  DetectionModels::Data data;
  data.models.push_back(make_detection_model(stone));
  data.models.push_back(make_detection_model(stone));
  Detection first, second, hidden;
  first.stone = 0_stone, first.T_C_O = T_C_O, first.score = 0.99, first.visible = 0.3;
  second = hidden = first;
  second.stone = 1_stone, second.T_C_O = make_pose({0.001, 0, 0}) * T_C_O, second.score = 0.98;
  const auto left = without_doubles({second, first}, data, scene, options);
  ASSERT_EQ(left.size(), 1U);
  EXPECT_EQ(left[0].stone, 0_stone) << "the better one";
  hidden.visible = 0.01;
  EXPECT_TRUE(without_doubles({hidden}, data, scene, options).empty()) << "no evidence is left";
}

TEST(Accept, APoseThatShowsLittleMustFitTheBetter) {
  const auto accepted = [](double score, double visible, double noise, Demand demand = Demand::kLikely) {
    Detection d;
    d.score = score, d.visible = visible, d.T_C_O = make_pose(Eigen::Vector3d(0, 0, 0.7));
    DetectionScene scene;
    scene.views.resize(1);
    scene.noise = noise;
    return acceptable(d, scene, {}, demand);
  };
  EXPECT_TRUE(accepted(0.86, 0.20, 0.0015));
  EXPECT_FALSE(accepted(0.84, 0.20, 0.0015));
  EXPECT_FALSE(accepted(0.94, 0.05, 0.0015)) << "wrong poses of hidden stones reached this";
  EXPECT_TRUE(accepted(0.99, 0.05, 0.0015));
  EXPECT_FALSE(accepted(1.00, 0.02, 0.0015)) << "no evidence";
  EXPECT_FALSE(accepted(0.88, 0.20, 0.0006)) << "a clean image shows mirror images this well";
  EXPECT_TRUE(accepted(0.99, 0.05, 0.0006)) << "the two are not added up";
  EXPECT_FALSE(accepted(0.94, 0.20, 0.0006, Demand::kCertain));
  EXPECT_TRUE(accepted(0.96, 0.20, 0.0006, Demand::kCertain));
  EXPECT_FALSE(accepted(0.89, 0.30, 0.0050, Demand::kCertain)) << "however noisy";
  EXPECT_FALSE(accepted(0.95, 0.15, 0.0050)) << "noise of this size fits whatever is not there";
  EXPECT_TRUE(accepted(0.90, 0.26, 0.0050));
}

}  // namespace
}  // namespace stonestack::detection
