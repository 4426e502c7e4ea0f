#include "stonestack/stacking/observe.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "motion/collision.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"

namespace stonestack::stacking {
namespace {

using namespace simulation;  // the cell that the loop works in here

/// One view at a simulated field with limestones 2 and 3, and where they are seen when nothing is known.
struct SeenField {
  Catalogue catalogue = read_catalogue(data_path("stones"));
  RobotModel robot = read_robot("ur10");
  DetectionOptions options;
  DetectionModels models{catalogue.stones, options};
  std::vector<StoneIndex> wanted{1_stone, 2_stone};
  CameraView view;
  std::vector<Sighting> seen;

  SeenField() {
    SimulationOptions world_options;
    world_options.seed = 7;
    SimulatedCell world(catalogue.stones, wanted, robot, CellLayout{}, world_options);
    Cell cell = world.cell();
    PlanningScene scene = make_planning_scene(cell.layout, robot, catalogue, {});
    const Eigen::Vector2d& field = cell.layout.field_centre;
    const auto route =
        plan_route_to_view(cell, scene, view_poses(cell.layout, {field.x(), field.y(), 0.05}, 0.6), {});
    view = take_view(cell, robot, route.value());
    seen = find({});
  }
  [[nodiscard]] std::vector<Sighting> find(const Arrangement& before) const {
    auto found = find_in_views({view}, models, wanted, {before, wanted}, options);
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.stone < b.stone; });
    return found;
  }
};

const SeenField& field() {
  static const SeenField made;
  return made;
}

TEST(PlanningSceneOfACell, ListsTheObstaclesAfterTheStonesAndTheGrippersMasses) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  CellLayout layout;
  layout.obstacles = {{"wall", {make_box({0.1, 1.0, 1.0})}, Pose(Eigen::Translation3d(0.4, 0.0, 0.5))}};
  layout.sensor_mass = 0.3;
  Arrangement arrangement;
  arrangement.loose = {{1_stone, Pose::Identity()}};
  const PlanningScene scene = make_planning_scene(layout, read_robot("ur10"), catalogue, arrangement);
  ASSERT_EQ(scene.objects.size(), 2u);
  EXPECT_EQ(scene.objects[1].name, "wall");
  EXPECT_DOUBLE_EQ(scene.objects[1].T_W_object.translation().x(), 0.4);
  EXPECT_DOUBLE_EQ(scene.gripper.sensor_mass, 0.3);
}

TEST(PlanningSceneOfACell, HasTheCameraWhereTheLayoutMountsIt) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  CellLayout layout;
  // What stands where the camera is mounted by default is not met with the camera on the other side.
  const Joints q = home_joints();
  const Pose T_W_T = forward(robot, q) * layout.T_F_T;
  layout.obstacles = {
      {"lamp", {make_sphere(0.015, 1)}, T_W_T * Pose(Eigen::Translation3d(0.0, 0.115, -0.193))}};
  CollisionRules rules;
  rules.padding = 0.0;
  EXPECT_TRUE(CollisionChecker(make_planning_scene(layout, robot, catalogue, {}), rules).collides(q));
  layout.T_T_C = Eigen::AngleAxisd(std::acos(-1.0), Eigen::Vector3d::UnitZ()) * layout.T_T_C;
  EXPECT_FALSE(CollisionChecker(make_planning_scene(layout, robot, catalogue, {}), rules).collides(q));
}

TEST(FindInViews, AnUnmovedStoneIsFoundInPlace) {
  ASSERT_EQ(field().seen.size(), 2U);
  Arrangement before;
  for (const Sighting& s : field().seen)
    before.loose.push_back({s.stone, Eigen::Translation3d(0.003, -0.002, 0) * s.T_W_O});
  const auto again = field().find(before);
  ASSERT_EQ(again.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto moved = difference(again[i].T_W_O, field().seen[i].T_W_O);
    EXPECT_LT(moved.translation, 0.001);
    EXPECT_LT(moved.angle, 0.01);
  }
}

TEST(FindInViews, HowCertainItIsWhichStoneItIsComesAlong) {
  std::vector<Stone> stones = field().catalogue.stones;
  stones.push_back(stones[1]);
  const DetectionModels models(stones, field().options);
  const auto found = find_in_views({field().view}, models, {1_stone}, {}, field().options);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_LT(found[0].certainty, 0.7) << "it may be its twin";
  for (const Sighting& s : field().seen) EXPECT_GT(s.certainty, 0.9);
}

/// View with the bare table where the stone is.
CameraView without(CameraView view, const Sighting& stone) {
  DepthImage& image = view.image;
  const Eigen::Vector3d p_W_eye = view.T_W_C.translation();
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u) {
      const Eigen::Vector3d ray_C = deproject(image.camera, u, v);
      const Eigen::Vector3d p_W = view.T_W_C * Eigen::Vector3d(image.at(u, v) * ray_C);
      if ((p_W - stone.T_W_O.translation()).head<2>().norm() > 0.12) continue;
      image.z[static_cast<std::size_t>(v * image.camera.width + u)] =
          static_cast<float>(-p_W_eye.z() / (view.T_W_C.linear() * ray_C).z());
    }
  return view;
}

TEST(FindInViews, AStoneThatWasNotKnownCountsOnlyIfAllViewsTogetherShowIt) {
  const auto find = [&](const std::vector<CameraView>& views, const std::vector<StoneIndex>& known) {
    return find_in_views(views, field().models, {1_stone}, {{}, known}, field().options).size();
  };
  const CameraView& view = field().view;
  const CameraView bare = without(view, field().seen[0]);
  EXPECT_EQ(find({bare}, {1_stone}), 0U);
  EXPECT_EQ(find({view, view}, {}), 1U);
  EXPECT_EQ(find({view, bare}, {}), 0U) << "the other view shows the table there";
  EXPECT_EQ(find({view, bare}, {1_stone}), 1U) << "a known stone is somewhere";
}

TEST(FindInViews, AStoneThatMovedFarIsFoundAnew) {
  Arrangement before;
  for (const Sighting& s : field().seen)
    before.loose.push_back({s.stone, Eigen::Translation3d(0.2, 0, 0) * s.T_W_O});
  EXPECT_EQ(field().find(before).size(), 2U);
}

/// A stone of the stack below one that is in its place is there, though no view shows it: what views like it
/// in the field is not taken for it.
TEST(FindInViews, AStoneHiddenBelowASeenOneIsNotSoughtElsewhere) {
  Arrangement before;
  const Pose T_W_hidden = Eigen::Translation3d(0, 0, -0.08) * field().seen[0].T_W_O;
  before.stack = {{field().seen[1].stone, T_W_hidden}, {field().seen[0].stone, field().seen[0].T_W_O}};
  const auto found = field().find(before);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].stone, field().seen[0].stone);
  std::swap(before.stack[0], before.stack[1]);  // nothing seen stands on it: it fell, perhaps
  EXPECT_EQ(field().find(before).size(), 2U);
}

TEST(GripperOption, ChoosesTheGripperWhereNoCellFileNamesOne) {
  const CellLayout layout = with_option_gripper({}, "robotiq-2f-85", false);
  EXPECT_EQ(layout.gripper, "robotiq-2f-85");
  EXPECT_EQ(gripper_of(layout).against, 1);
  EXPECT_EQ(gripper_of(layout).max_opening, 0.085);
  const PlanningScene scene = make_planning_scene(layout, read_robot("ur10"), {}, {});
  EXPECT_EQ(scene.opening, 0.085);
  EXPECT_NEAR(scene.T_F_T.translation().z(), 0.201, 1e-12);
  EXPECT_EQ(with_option_gripper({}, "", false).gripper, "robotiq-3f");
  EXPECT_THROW((void)with_option_gripper({}, "robotiq-2f-85", true), InvalidArgument);
  EXPECT_NO_THROW((void)with_option_gripper({}, "robotiq-3f", true)) << "the same as in the cell file";
  EXPECT_THROW((void)with_option_gripper({}, "robotiq-9f", false), FileError);
}

TEST(GripperOption, LinkageIsTheArcOfTheGrippersOwnFile) {
  CellLayout layout = with_option_gripper({}, "robotiq-2f-85", false);
  layout.linkage = "three_finger";
  EXPECT_EQ(gripper_of(layout).linkage, motion::Linkage::kArc);
  layout.linkage = "scissor";
  EXPECT_THROW((void)gripper_of(layout), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::stacking
