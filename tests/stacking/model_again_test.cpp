#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/quantile.hpp"
#include "geometry/convex_pieces.hpp"
#include "geometry/surface_tree.hpp"
#include "modelling/seen_things.hpp"
#include "rooms.hpp"
#include "stacking/model_again.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

using modelling::align_scene;
using modelling::AlignedScene;
using modelling::LyingObject;
using modelling::test::cameras_around;
using modelling::test::Thing;
using modelling::test::views_of;

constexpr double kHeight = 0.04;                  // m, of the frustum ...
constexpr double kWide = 0.055, kNarrow = 0.013;  // ... and half of its sides along x

/// A frustum on its wide side: no camera above the table sees its walls once it lies on the narrow side.
Thing frustum(bool upside_down) {
  Mesh corners;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0}) {
      corners.vertices.emplace_back(kWide * x, 0.050 * y, 0.0);
      corners.vertices.emplace_back(kNarrow * x, 0.010 * y, kHeight);
    }
  Thing thing{convex_hull(corners), Pose::Identity()};
  if (upside_down)
    thing.T_W_O = Eigen::Translation3d(0.0, 0.0, kHeight) * Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX());
  return thing;
}

/// Candidate of a first survey for what was moved then: the turn and shift that was meant, in W.
StoneCandidate moved_candidate(const AlignedScene& first, const Pose& meant_W) {
  StoneCandidate candidate;
  const LyingObject lying{&first, 0};
  candidate.model = modelling::model_object({&lying, 1}, {}).value();
  candidate.made_of = {lying};
  candidate.made.name = "stone_1";
  candidate.stone = stone_of_model(candidate.model, candidate.made, {});
  candidate.T_W_O = meant_W * candidate.stone.T_O_file.inverse();
  candidate.moved = candidate.let_go = true;
  return candidate;
}

TEST(StoneOfModel, SaysWhatOfItsSurfaceWasSeen) {
  const AlignedScene scene = align_scene(views_of({frustum(false)}, cameras_around(4)));
  ASSERT_EQ(scene.segmentation.objects.size(), 1U);
  const LyingObject lying{&scene, 0};
  ModelledStone made;
  made.name = "stone_1";
  const Stone stone = stone_of_model(modelling::model_object({&lying, 1}, {}).value(), made, {});
  ASSERT_TRUE(stone.surface.has_value());
  ASSERT_EQ(stone.surface->sigma.size(), stone.scan.vertices.size());
  ASSERT_EQ(stone.surface->up_O_at_rest.size(), 1U);
  const Eigen::Vector3d& up_O = stone.surface->up_O_at_rest[0];
  double low = 1e9, high = -1e9;
  for (const auto& p : stone.scan.vertices)
    low = std::min(low, up_O.dot(p)), high = std::max(high, up_O.dot(p));
  int top_seen = 0, top = 0, bottom_seen = 0, bottom = 0;
  for (std::size_t v = 0; v < stone.scan.vertices.size(); ++v) {
    const double z = up_O.dot(stone.scan.vertices[v]);
    if (z > high - 0.002) ++top, top_seen += stone.surface->seen[v];
    if (z < low + 0.001) ++bottom, bottom_seen += stone.surface->seen[v];
  }
  EXPECT_GT(top_seen, 0.9 * top);
  EXPECT_LT(bottom_seen, 0.3 * bottom);
}

CellLayout layout_here() {
  CellLayout layout;
  layout.field_centre = Eigen::Vector2d::Zero();
  return layout;
}

/// Distance that nine of ten points of a true surface above `z` have at most from a candidate's, as it should
/// lie [m].
double off_above(const Thing& truth, double z, const StoneCandidate& candidate) {
  const SurfaceTree surface(candidate.stone.scan);
  std::vector<double> off;
  for (const auto& sample : sample_surface(truth.mesh, 0.005)) {
    const Eigen::Vector3d p_W = truth.T_W_O * sample.point;
    if (p_W.z() > z) off.push_back(std::abs(surface.nearest(candidate.T_W_O.inverse() * p_W).distance));
  }
  return quantile(off, 0.9);
}

TEST(ModelAgain, AStoneThatLiesUpsideDownIsModelledAsItLies) {
  const Thing lay = frustum(false), lies = frustum(true);
  const AlignedScene first = align_scene(views_of({lay}, cameras_around(4)));
  const AlignedScene second = align_scene(views_of({lies}, cameras_around(4)));
  std::vector<StoneCandidate> candidates{moved_candidate(first, lies.T_W_O * lay.T_W_O.inverse())};
  candidates[0].made.mass = 0.7;
  model_again(second, layout_here(), {}, candidates);
  const StoneCandidate& made = candidates.front();
  EXPECT_FALSE(made.moved) << "it is known where it lies";
  ASSERT_EQ(made.made_of.size(), 1U);
  EXPECT_EQ(made.made_of[0].scene, &second);
  EXPECT_EQ(made.apart.size(), 1U) << "its other side is kept";
  EXPECT_FALSE(made.made.turned);
  EXPECT_THAT(made.made.note, testing::HasSubstr("modelled from one side"));
  EXPECT_LT(off_above(lies, kHeight - 0.005, made), 0.003);
  EXPECT_NEAR(made.stone.mass.mass, 0.7, 1e-9) << "as it was weighed";
}

TEST(ModelAgain, AStoneOnItsSideIsJoinedFromBothLooks) {
  const Thing lay = modelling::test::lying_stone(3, 0.0, 0.0);
  Thing lies = lay;
  lies.T_W_O = Eigen::AngleAxisd(1.4, Eigen::Vector3d::UnitX()) * lay.T_W_O;
  double lowest = 1.0;
  for (const auto& v : lies.mesh.vertices) lowest = std::min(lowest, (lies.T_W_O * v).z());
  lies.T_W_O = Eigen::Translation3d(0.01, -0.02, -lowest) * lies.T_W_O;
  const AlignedScene first = align_scene(views_of({lay}, cameras_around(4)));
  const AlignedScene second = align_scene(views_of({lies}, cameras_around(4)));
  std::vector<StoneCandidate> candidates{moved_candidate(first, lies.T_W_O * lay.T_W_O.inverse())};
  model_again(second, layout_here(), {}, candidates);
  EXPECT_TRUE(candidates[0].found_again);
  EXPECT_EQ(candidates[0].made_of.size(), 2U);
  EXPECT_TRUE(candidates[0].made.turned);
  EXPECT_LT(off_above(lies, 0.01, candidates[0]), 0.004);
}

/// A thing turned about a level axis, on the table.
Thing turned_by(const Thing& thing, double angle) {
  Thing turned = thing;
  turned.T_W_O = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()) * thing.T_W_O;
  double lowest = 1.0;
  for (const auto& v : turned.mesh.vertices) lowest = std::min(lowest, (turned.T_W_O * v).z());
  turned.T_W_O = Eigen::Translation3d(0.0, 0.0, -lowest) * turned.T_W_O;
  return turned;
}

TEST(ModelAgain, BothSidesAreJoinedOnceALookShowsHowTheyBelongTogether) {
  const Thing lay = modelling::test::lying_stone(3, 0.0, 0.0);
  const Thing over = turned_by(lay, M_PI), side = turned_by(lay, 0.5 * M_PI);
  const AlignedScene first = align_scene(views_of({lay}, cameras_around(4)));
  const AlignedScene second = align_scene(views_of({over}, cameras_around(4)));
  const AlignedScene third = align_scene(views_of({side}, cameras_around(4)));
  std::vector<StoneCandidate> candidates{moved_candidate(second, side.T_W_O * over.T_W_O.inverse())};
  StoneCandidate& stone = candidates[0];
  stone.apart = {{&first, 0}};  // not recognised upside down
  model_again(third, layout_here(), {}, candidates);
  ASSERT_EQ(stone.made_of.size(), 3U);
  EXPECT_TRUE(stone.apart.empty());
  EXPECT_EQ(stone.stone.surface->up_O_at_rest.size(), 3U);
  EXPECT_GT(stone.made.seen_share, 0.85);
  EXPECT_LT(off_above(side, -1.0, stone), 0.004) << "all around";
}

TEST(ModelAgain, AStoneSeenFromBothSidesIsNotTakenForAnother) {
  const Thing stands = modelling::test::lying_stone(3, 0.0, 0.0);
  const Thing lay = modelling::test::lying_stone(4, 0.15, 0.0);
  const AlignedScene first = align_scene(views_of({stands, lay}, cameras_around(4)));
  const AlignedScene second = align_scene(views_of({stands}, cameras_around(4)));  // the other is lost
  ASSERT_EQ(first.segmentation.objects.size(), 2U);
  std::vector<StoneCandidate> candidates;
  std::size_t lost = 0;
  for (int object = 0; object < 2; ++object) {
    StoneCandidate candidate;
    candidate.made_of = {{&first, object}};
    candidate.object = object;
    candidate.model = modelling::model_object(candidate.made_of, {}).value();
    candidate.made.name = concat("stone_", object + 1);
    candidate.stone = stone_of_model(candidate.model, candidate.made, {});
    candidate.T_W_O = candidate.stone.T_O_file.inverse();
    candidate.moved = candidate.T_W_O.translation().x() > 0.075;
    if (candidate.moved) {
      candidate.p_W_seen = Eigen::Vector2d(0.08, 0.0);  // near the one that stands
      lost = candidates.size();
    } else {
      candidate.made_of.push_back(candidate.made_of.front());
    }
    candidates.push_back(candidate);
  }
  model_again(second, layout_here(), {}, candidates);
  EXPECT_TRUE(candidates[lost].moved) << "it is not where the other one stands";
  EXPECT_EQ(candidates[lost].made_of.front().scene, &first);
  EXPECT_FALSE(candidates[1 - lost].moved);
}

// A part of a stone that two of six views part from it would become a stone of its own.
TEST(UnfitView, AnObjectThatFewViewsShowIsNone) {
  AlignedScene scene = align_scene(views_of({frustum(false)}, cameras_around(6)));
  ASSERT_EQ(scene.segmentation.objects.size(), 1U);
  EXPECT_EQ(unfit_view(scene, 0), "");
  scene.segmentation.objects[0].views = 3;
  EXPECT_EQ(unfit_view(scene, 0), "");
  scene.segmentation.objects[0].views = 2;
  EXPECT_THAT(unfit_view(scene, 0), testing::HasSubstr("2 of 6"));
}

TEST(ModelAgain, AStoneThatIsNotSeenAnyMoreKeepsItsModelAndIsNotPlaced) {
  const Thing lay = frustum(false);
  Thing elsewhere = frustum(true);
  elsewhere.T_W_O = Eigen::Translation3d(0.2, 0.0, 0.0) * elsewhere.T_W_O;
  const AlignedScene first = align_scene(views_of({lay}, cameras_around(4)));
  const AlignedScene second = align_scene(views_of({elsewhere}, cameras_around(4)));
  std::vector<StoneCandidate> candidates{moved_candidate(first, Pose::Identity())};
  const std::size_t vertices = candidates[0].model.mesh.vertices.size();
  model_again(second, layout_here(), {}, candidates);
  EXPECT_TRUE(candidates[0].moved);
  EXPECT_EQ(candidates[0].model.mesh.vertices.size(), vertices);
  EXPECT_THAT(candidates[0].made.note, testing::HasSubstr("not recognised"));
}

}  // namespace
}  // namespace stonestack::stacking
