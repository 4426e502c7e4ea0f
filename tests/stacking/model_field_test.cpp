#include "stacking/model_field.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/quantile.hpp"
#include "geometry/surface_tree.hpp"
#include "rooms.hpp"
#include "stacking/survey.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack::stacking {
namespace {

using namespace report;

TEST(Survey, EachViewShowsWhatTheOnesBeforeDidNot) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  SimulatedCell world(catalogue.stones, {StoneIndex(0)}, robot, CellLayout{}, options_of_cell("ideal"));
  Cell cell = world.cell();
  const Eigen::Vector3d p_W(cell.layout.field_centre.x(), cell.layout.field_centre.y(), 0.04);
  const PlanningScene scene = make_planning_scene(cell.layout, robot, {}, {});
  const auto views = survey(cell, scene, dome_over(p_W), p_W, 4, 0.55, {});
  ASSERT_EQ(views.size(), 4U);
  for (std::size_t a = 0; a < views.size(); ++a) {
    const Eigen::Vector3d axis = views[a].view.T_W_C.linear().col(2);
    const Eigen::Vector3d to_target = (p_W - views[a].view.T_W_C.translation()).normalized();
    EXPECT_GT(axis.dot(to_target), 0.999) << "the camera looks at the field";
    for (std::size_t b = 0; b < a; ++b)
      EXPECT_LT(axis.dot(views[b].view.T_W_C.linear().col(2)), std::cos(0.5)) << a << " and " << b;
  }
}

TEST(Survey, NothingThatIsWantedNeedsNoMoreThanOneLook) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  SimulatedCell world(catalogue.stones, {StoneIndex(0)}, robot, CellLayout{}, options_of_cell("ideal"));
  Cell cell = world.cell();
  const Eigen::Vector3d p_W(cell.layout.field_centre.x(), cell.layout.field_centre.y(), 0.04);
  const std::vector<SurfaceElement> top{{p_W, Eigen::Vector3d::UnitZ(), 1.0}};
  EXPECT_EQ(survey(cell, make_planning_scene(cell.layout, robot, {}, {}), top, p_W, 4, 0.55, {}).size(), 1U);
}

TEST(ModelField, StonesThatNobodyScannedAreModelledTurnedAndWeighed) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  SimulationOptions simulation = options_of_cell("mild");
  simulation.seed = 5;
  SimulatedCell world(catalogue.stones, {StoneIndex(1), StoneIndex(3)}, robot, CellLayout{}, simulation);
  Cell cell = world.cell();
  const ModelledField field = model_field(cell, robot);
  ASSERT_EQ(field.stones.size(), 2U);
  ASSERT_EQ(field.catalogue.stones.size(), 2U);
  EXPECT_LT(field.apart_after, field.apart_before + 1e-9);
  const std::vector<Pose> T_W_O = world.truth().T_W_O;
  for (std::size_t k = 0; k < 2; ++k) {
    const ModelledStone& made = field.stones[k];
    const Stone& model = field.catalogue.stones[k];
    EXPECT_EQ(made.name, model.name);
    EXPECT_TRUE(is_closed(model.scan));
    const auto distance = [&](StoneIndex stone) {
      return (at(T_W_O, stone).translation() - made.T_W_O.translation()).norm();
    };
    const StoneIndex is = distance(StoneIndex(1)) < distance(StoneIndex(3)) ? StoneIndex(1) : StoneIndex(3);
    EXPECT_LT(distance(is), 0.012);
    EXPECT_GT(made.seen_share, 0.6);
    ASSERT_TRUE(made.mass.has_value()) << made.note;
    EXPECT_NEAR(*made.mass / catalogue[is].mass.mass, 1.0, 0.05);
    const SurfaceTree truth(catalogue[is].scan);
    std::vector<double> off;
    for (const auto& v : model.scan.vertices)
      off.push_back(std::abs(truth.nearest(at(T_W_O, is).inverse() * made.T_W_O * v).distance));
    EXPECT_LT(quantile(off, 0.5), 0.004) << "pose and shape together";
  }
}

TEST(ModelField, AnEmptyFieldGivesNoStone) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  SimulatedCell world(catalogue.stones, {}, robot, CellLayout{}, options_of_cell("ideal"));
  Cell cell = world.cell();
  ModelFieldOptions options;
  options.first_views = 2;
  const ModelledField field = model_field(cell, robot, options);
  EXPECT_TRUE(field.catalogue.stones.empty());
  EXPECT_EQ(field.views, 2);
}

}  // namespace
}  // namespace stonestack::stacking
