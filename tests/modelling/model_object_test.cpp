#include <gtest/gtest.h>

#include <limits>

#include "core/quantile.hpp"
#include "geometry/surface_tree.hpp"
#include "modelling/constants.hpp"
#include "seen_things.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::modelling {
namespace {

using namespace test;

/// Distances of the model's seen and unseen vertices from the true surface.
struct Off {
  std::vector<double> seen, unseen;
};

Off off_truth(const ObjectModel& model, const Thing& thing) {
  const SurfaceTree truth(thing.mesh);
  const Pose T_O_W = thing.T_W_O.inverse();
  Off off;
  for (std::size_t v = 0; v < model.mesh.vertices.size(); ++v)
    (model.seen[v] != 0 ? off.seen : off.unseen)
        .push_back(std::abs(truth.nearest(T_O_W * model.mesh.vertices[v]).distance));
  return off;
}

TEST(ModelObject, SeenSurfaceIsWithinHalfAMillimetre) {
  const Thing stone = lying_stone(3, 0.0, 0.0);
  const AlignedScene scene = align_scene(views_of({stone}, cameras_around(6)));
  const auto models = model_objects(scene);
  ASSERT_EQ(models.size(), 1U);
  const ObjectModel& model = models.front().value();
  EXPECT_TRUE(is_closed(model.mesh));
  EXPECT_EQ(model.views, 6);
  EXPECT_GT(model.seen_share, 0.4);
  EXPECT_LT(model.seen_share, 0.9);  // no view shows the underside
  const Off off = off_truth(model, stone);
  EXPECT_LT(quantile(off.seen, 0.5), 0.0006);
  EXPECT_LT(quantile(off.seen, 0.95), 0.002);
}

TEST(ModelObject, TheSameViewsGiveTheSameMeshToTheLastBit) {
  const AlignedScene scene = align_scene(views_of({lying_stone(3, 0.0, 0.0)}, cameras_around(3)));
  const Mesh first = model_objects(scene).front()->mesh;
  const std::vector<Mesh> elsewhere(3, first);  // so that the second has other addresses
  const Mesh second = model_objects(scene).front()->mesh;
  EXPECT_EQ(first.vertices, second.vertices);
  EXPECT_EQ(first.faces, second.faces);
}

TEST(ModelObject, TheUnseenUndersideEndsAtTheTable) {
  const Thing box{make_box({0.10, 0.08, 0.05}), make_pose({0, 0, 0.025})};
  const AlignedScene scene = align_scene(views_of({box}, cameras_around(6)));
  const auto models = model_objects(scene);
  ASSERT_EQ(models.size(), 1U);
  EXPECT_NEAR(volume(models.front()->mesh), 0.10 * 0.08 * 0.05, 0.04 * 0.10 * 0.08 * 0.05);
  EXPECT_NEAR(bounds(models.front()->mesh).min().z(), 0.0, 0.0015);
}

TEST(ModelObject, UncertaintyGrowsAwayFromWhatWasSeen) {
  const Thing stone = lying_stone(3, 0.0, 0.0);
  const ObjectModel model = model_objects(align_scene(views_of({stone}, cameras_around(4)))).front().value();
  double seen = 0.0, unseen = 0.0;
  for (std::size_t v = 0; v < model.sigma.size(); ++v)
    (model.seen[v] != 0 ? seen : unseen) = std::max(model.seen[v] != 0 ? seen : unseen, model.sigma[v]);
  EXPECT_LT(seen, 0.002);
  EXPECT_GT(unseen, 0.002);
}

/// Median error of seen vertices over the stated standard deviation without what views share, 1 for normal
/// errors that are as large as stated. Rims err by millimetres, and no noise is the reason.
double seen_errors_over_sigma(const ObjectModel& model, const Thing& thing) {
  constexpr double kOfMedian = 1.4826;
  const SurfaceTree truth(thing.mesh);
  const Pose T_O_W = thing.T_W_O.inverse();
  std::vector<double> ratios;
  for (std::size_t v = 0; v < model.mesh.vertices.size(); ++v) {
    if (model.seen[v] == 0) continue;
    const double own = std::sqrt(std::pow(model.sigma[v], 2) - std::pow(kSharedSigma, 2));
    ratios.push_back(std::abs(truth.nearest(T_O_W * model.mesh.vertices[v]).distance) / own);
  }
  return kOfMedian * quantile(ratios, 0.5);
}

// The views share no error, so the model's are those that each view has alone. A vertex lies between nodes of
// the volume, whose mean errs less than each of them: by 2/3 within a square of four that err independently.
TEST(ModelObject, StatesTheErrorsItHas) {
  const Thing stone = lying_stone(3, 0.0, 0.0);
  for (const double noise : {0.0003, 0.0012})
    for (const int views : {3, 8}) {
      const auto models = model_objects(align_scene(views_of({stone}, cameras_around(views), noise)));
      ASSERT_EQ(models.size(), 1U);
      const double ratio = seen_errors_over_sigma(models.front().value(), stone);
      EXPECT_GT(ratio, 0.6) << noise << " m in " << views << " views";
      EXPECT_LT(ratio, 1.6) << noise << " m in " << views << " views";
    }
}

TEST(ModelObject, TwoRestingPosesShowAllSides) {
  const Thing first = lying_stone(3, 0.0, 0.0);
  Thing second = first;  // upside down
  second.T_W_O = Pose(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()));
  double lowest = 1.0;
  for (const auto& v : second.mesh.vertices) lowest = std::min(lowest, (second.T_W_O * v).z());
  second.T_W_O = Eigen::Translation3d(0.02, 0.01, -lowest) * second.T_W_O;
  const AlignedScene a = align_scene(views_of({first}, cameras_around(5)));
  const AlignedScene b = align_scene(views_of({second}, cameras_around(5)));
  const LyingObject lying[] = {{&a, 0, first.T_W_O}, {&b, 0, second.T_W_O}};
  const ObjectModel model = model_object(lying).value();
  EXPECT_GT(model.seen_share, 0.9);
  const Thing in_O{first.mesh, Pose::Identity()};
  Off off = off_truth(model, in_O);
  off.seen.insert(off.seen.end(), off.unseen.begin(), off.unseen.end());
  EXPECT_LT(quantile(off.seen, 0.5), 0.0007);
  EXPECT_LT(quantile(off.seen, 0.95), 0.002);
  EXPECT_NEAR(volume(model.mesh) / volume(first.mesh), 1.0, 0.03);
}

TEST(ModelObject, AnObjectThatIsNotThereIsRefused) {
  const AlignedScene scene = align_scene(views_of({lying_stone(3, 0.0, 0.0)}, cameras_around(2)));
  const LyingObject lying{&scene, 7};
  EXPECT_THROW((void)model_object({&lying, 1}), InvalidArgument);
  EXPECT_THROW((void)model_object({}), InvalidArgument);
}

TEST(ModelObject, AnObjectThatIsTooLargeForItsCellsLeavesTheOthers) {
  const Thing large{make_box({0.30, 0.26, 0.14}), make_pose({0.12, 0.0, 0.07})},
      small{make_box({0.04, 0.04, 0.03}), make_pose({-0.12, 0.0, 0.015})};
  const AlignedScene scene = align_scene(views_of({large, small}, cameras_around(2)));
  ASSERT_EQ(scene.segmentation.objects.size(), 2U);
  ModellingOptions options;
  options.voxel = 0.0006;  // 64 million of these fill 14 l, the large box with its margins 20 l
  const auto models = model_objects(scene, options);
  ASSERT_EQ(models.size(), 2U);
  EXPECT_FALSE(models[0].has_value());
  EXPECT_TRUE(models[1].has_value());
}

TEST(ModelObject, ViewsThatSeeThroughAllOfItGiveNoModel) {
  ModellingOptions options;
  options.refine_poses = false;
  const AlignedScene scene = align_scene(views_of({lying_stone(3, 0.0, 0.0)}, cameras_around(2)), options);
  const AlignedScene wrong = align_scene(views_of({lying_stone(3, 0.2, 0.0)}, cameras_around(10)), options);
  ASSERT_EQ(wrong.segmentation.objects.size(), 1U);
  // Joined so that it lies below the first table, and its views see through the first place.
  const LyingObject lying[] = {{&scene, 0, Pose::Identity()}, {&wrong, 0, make_pose({0.0, 0.0, 0.08})}};
  EXPECT_FALSE(model_object(lying).has_value());
}

TEST(ModelObject, AVolumeThatDoesNotFitIsRefused) {
  const AlignedScene scene = align_scene(views_of({lying_stone(3, 0.0, 0.0)}, cameras_around(2)));
  const LyingObject lying{&scene, 0};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (double ModellingOptions::*length :
       {&ModellingOptions::voxel, &ModellingOptions::truncation, &ModellingOptions::facet})
    for (const double value : {0.0, -1.0, nan}) {
      ModellingOptions options;
      options.*length = value;
      EXPECT_THROW((void)model_object({&lying, 1}, options), InvalidArgument) << value;
      EXPECT_THROW((void)align_scene(scene.views, options), InvalidArgument) << value;
    }
}

}  // namespace
}  // namespace stonestack::modelling
