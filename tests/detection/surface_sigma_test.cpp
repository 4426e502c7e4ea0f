// Models of which a part is a guess: what no view showed when they were made.
#include <gtest/gtest.h>

#include <cmath>

#include "core/constants.hpp"
#include "detection/features/models.hpp"
#include "detection/hypotheses/depth_scale.hpp"
#include "detection/hypotheses/joint_refine.hpp"
#include "detection/hypotheses/refine.hpp"
#include "detection/judge/verify.hpp"
#include "detection/scene/preprocess.hpp"
#include "detection/test_scene.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::detection {
namespace {

constexpr double kBulge = 0.010;    // m, by which the guess errs at most: one standard deviation
constexpr double kGuessed = 0.010;  // m beyond the middle, along kUnseen, where the guess begins

const Eigen::Vector3d kUnseen = Eigen::Vector3d(0.17, 0.98, 0.3).normalized();  // of the stone, in O

/// How far the guess errs at a place, outwards.
double bulge_at(const Eigen::Vector3d& p_O) {
  return kBulge * std::clamp((p_O.dot(kUnseen) - kGuessed) / 0.03, 0.0, 1.0);
}

/// The stone with one side that nobody saw and that was guessed too large. It does not say so.
Stone with_guess(Stone stone) {
  for (Mesh* mesh : {&stone.mesh, &stone.scan})
    for (Eigen::Vector3d& p : mesh->vertices) p += bulge_at(p) * p.normalized();
  return stone;
}

/// Likewise, but says how well its surface is known.
Stone with_known_guess(const Stone& stone) {
  Stone out = with_guess(stone);
  SurfaceKnowledge surface;
  for (const Eigen::Vector3d& p : stone.scan.vertices) {
    surface.sigma.push_back(0.0005 + bulge_at(p));
    surface.seen.push_back(bulge_at(p) > 0.0 ? 0 : 1);
  }
  out.surface = surface;
  return out;
}

class GuessedSide : public ::testing::Test {
 protected:
  Stone stone = test::make_test_stone(5);
  Stone guessed = with_guess(stone), known = with_known_guess(stone);
  Pose T_W_C = test::make_camera_pose(0.5, 1.0);
  Pose T_W_O = test::on_table(stone, Eigen::Quaterniond(Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitZ())),
                              0.02, -0.01);
  Pose T_C_O = T_W_C.inverse() * T_W_O;
  DepthImage image = test::with_noise(test::look_at({{&stone, T_W_O}}, T_W_C), 0.0008, 1);
  DetectionScene scene = preprocess(image, {}, true, {});

  [[nodiscard]] double score(const Stone& model, const Pose& T) const {
    VerifyOptions strict;
    strict.contour = true;
    return verify_pose(make_detection_model(model), T, scene, strict).score;
  }
  [[nodiscard]] Detection at_truth() const {
    Detection there;
    there.stone = 0_stone;
    there.T_C_O = T_C_O;
    return there;
  }
  /// The pose that the fine refinement finds from the true one.
  [[nodiscard]] PoseDifference off_after_refinement(const Stone& model) const {
    const DetectionModel made = make_detection_model(model);
    const auto near = points_near(made, T_C_O, scene.surface, 0.015, 3000);
    return difference(refine_pose(made, T_C_O, scene.surface, near, {}).T_C_O, T_C_O);
  }
};

TEST_F(GuessedSide, CostsLittleWhereItIsKnownToBeAGuess) {
  const double accept = DetectionOptions{}.accept_score;
  EXPECT_LT(score(guessed, T_C_O), accept) << "the trap is gone: the guess fits";
  EXPECT_GT(score(known, T_C_O), accept + 0.04);
}

TEST_F(GuessedSide, GivesAWrongPoseNoScore) {
  const Eigen::Vector3d up_C = scene.table_C->normal;
  EXPECT_LT(score(known, make_pose(0.05 * up_C) * T_C_O), 0.3) << "in the air";
  EXPECT_LT(score(known, make_pose({0.02, 0, 0}) * T_C_O), 0.7) << "aside";
  const Pose turned = T_C_O * Pose(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()));
  EXPECT_LT(score(known, turned), 0.7) << "turned by 17 deg";
}

TEST_F(GuessedSide, CountsLessAsVisibleSurface) {
  const Verdict of_scan = verify_pose(make_detection_model(stone), T_C_O, scene, {});
  const Verdict of_guess = verify_pose(make_detection_model(known), T_C_O, scene, {});
  EXPECT_LT(of_guess.visible, 0.9 * of_scan.visible);
  EXPECT_GT(of_guess.visible, 0.3 * of_scan.visible);
}

TEST_F(GuessedSide, PullsThePoseLess) {
  const PoseDifference trusting = off_after_refinement(guessed), wary = off_after_refinement(known);
  EXPECT_GT(trusting.translation, 0.002) << "the trap is gone: the guess pulls at nothing";
  EXPECT_LT(wary.translation, 0.5 * trusting.translation);
  EXPECT_LT(wary.angle, 0.7 * trusting.angle + 0.2 * kDegree);
}

TEST_F(GuessedSide, PullsTheDepthScaleLess) {
  const auto scale_by = [&](const Stone& model) {
    return fit_depth_scale({at_truth()}, DetectionModels(std::vector<Stone>{model}).data(), scene).factor;
  };
  const double of_scan = scale_by(stone);
  EXPECT_NEAR(of_scan, 1.0, 0.01);
  const double trusting = std::abs(scale_by(guessed) - of_scan), wary = std::abs(scale_by(known) - of_scan);
  EXPECT_GT(trusting, 0.01) << "the trap is gone: the guess pulls at nothing";
  EXPECT_LT(wary, 0.5 * trusting);
}

TEST_F(GuessedSide, IsStatedInTheCovariance) {
  const auto stated = [&](const Stone& model) {
    return refined_together({at_truth()}, DetectionModels(std::vector<Stone>{model}).data(), scene).front();
  };
  const Detection of_scan = stated(stone), of_guess = stated(known);
  const auto position = [](const Detection& d) -> Eigen::Matrix3d {
    return d.covariance.topLeftCorner(3, 3);
  };
  EXPECT_GT(position(of_guess).trace(), 1.3 * position(of_scan).trace());
  const Eigen::Vector3d off = of_guess.T_C_O.translation() - T_C_O.translation();
  EXPECT_LT(off.dot(position(of_guess).inverse() * off), 14.2) << "99.7 % of three";
}

TEST_F(GuessedSide, IsFoundInAnImage) {
  const auto found = detect_stones(image, DetectionModels(std::vector<Stone>{known}));
  ASSERT_EQ(found.detections.size(), 1U) << found.note;
  const PoseDifference off = difference(found.detections.front().T_C_O, T_C_O);
  EXPECT_LT(off.translation, 0.004);
  EXPECT_LT(off.angle, 4 * kDegree);
}

TEST_F(GuessedSide, ExplainsSurfaceWithinTwoStandardDeviations) {
  const Eigen::Vector3d on_guess = [&] {
    Eigen::Vector3d furthest = guessed.mesh.vertices.front();
    for (const auto& p : guessed.mesh.vertices)
      if (p.dot(kUnseen) > furthest.dot(kUnseen)) furthest = p;
    return furthest;
  }();
  const Eigen::Vector3f beside = (on_guess + 0.010 * kUnseen).cast<float>();
  EXPECT_FALSE(explains(make_detection_model(guessed), Pose::Identity(), beside, 0.004));
  EXPECT_TRUE(explains(make_detection_model(known), Pose::Identity(), beside, 0.004));
}

TEST_F(GuessedSide, ReachesIntoTheTableAtNoCost) {
  Stone deep = stone;  // its underside is guessed too deep
  SurfaceKnowledge surface;
  const auto below = [](const Eigen::Vector3d& p_O) { return 0.02 * std::clamp(-p_O.z() / 0.02, 0.0, 1.0); };
  for (const Eigen::Vector3d& p : stone.scan.vertices) {
    surface.sigma.push_back(below(p));
    surface.seen.push_back(below(p) > 0.0 ? 0 : 1);
  }
  for (Mesh* mesh : {&deep.mesh, &deep.scan})
    for (Eigen::Vector3d& p : mesh->vertices) p.z() -= below(p);
  EXPECT_GT(verify_pose(make_detection_model(deep), T_C_O, scene, {}).lost.below, 0.2);
  deep.surface = surface;
  EXPECT_EQ(verify_pose(make_detection_model(deep), T_C_O, scene, {}).lost.below, 0.0);
}

TEST_F(GuessedSide, MayEndWithinTheStone) {
  Stone flat = stone;  // the guessed side lies within the stone: the surface goes on where the model ends
  SurfaceKnowledge surface;
  for (const Eigen::Vector3d& p : stone.scan.vertices) {
    surface.sigma.push_back(bulge_at(p));
    surface.seen.push_back(bulge_at(p) > 0.0 ? 0 : 1);
  }
  for (Mesh* mesh : {&flat.mesh, &flat.scan})
    for (Eigen::Vector3d& p : mesh->vertices) p -= 1.5 * bulge_at(p) * p.normalized();
  VerifyOptions strict;
  strict.contour = true;
  const ScoreLosses trusting = verify_pose(make_detection_model(flat), T_C_O, scene, strict).lost;
  flat.surface = surface;
  const ScoreLosses wary = verify_pose(make_detection_model(flat), T_C_O, scene, strict).lost;
  EXPECT_GT(trusting.outline, 0.05) << "the trap is gone: the surface ends with the model";
  EXPECT_LT(wary.outline, 0.5 * trusting.outline);
}

TEST(SurfaceSigma, IsThatOfTheNearestPlaceOfTheScan) {
  const Stone known = with_known_guess(test::make_test_stone(5));
  const DetectionModel model = make_detection_model(known);
  ASSERT_EQ(model.sigma.samples.size(), model.surface.points.size());
  ASSERT_EQ(model.sigma.mesh.size(), model.mesh.vertices.size());
  ASSERT_EQ(model.sigma.drawn.size(), model.drawn.vertices.size());
  for (std::size_t i = 0; i < model.surface.points.size(); ++i) {
    const double along = model.surface.points[i].cast<double>().dot(kUnseen);
    if (along < kGuessed - 0.01) {
      EXPECT_NEAR(model.sigma.samples[i], 0.0005, 1e-6);
    }
    if (along > kGuessed + 0.05) {
      EXPECT_NEAR(model.sigma.samples[i], 0.0005 + kBulge, 1e-6);
    }
  }
}

TEST(SurfaceSigma, IsZeroForAScan) {
  const DetectionModel model = make_detection_model(test::make_test_stone(5));
  for (const auto* list : {&model.sigma.samples, &model.sigma.mesh, &model.sigma.drawn})
    for (const float sigma : *list) EXPECT_EQ(sigma, 0.0F);
  EXPECT_EQ(widened(0.005, 0.0), 0.005);
  EXPECT_EQ(evidence_weight(0.005, 0.0), 1.0);
}

TEST(SurfaceSigma, NeedsOneEntryAVertex) {
  Stone stone = with_known_guess(test::make_test_stone(5));
  stone.surface->sigma.pop_back();
  EXPECT_THROW((void)make_detection_model(stone), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::detection
