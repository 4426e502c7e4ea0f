#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "physics/shape.hpp"
#include "stacking/heard.hpp"
#include "stacking/saved_states.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"
#include "temporary_folder.hpp"

/// Actions of the loop on a stone that came to lie against the base of its tower.
namespace stonestack::stacking {
namespace {

using namespace simulation;  // the cell that the loop works in here

/// Distance [m] between the scans of two stones, from samples of the first; negative: they overlap.
double gap(const ContactShape& a, const Pose& T_W_a, const ContactShape& b, const Pose& T_W_b) {
  double min_extent = 1.0;
  for (const SurfaceSample& sample : a.samples)
    min_extent = std::min(min_extent, b.distance.distance(T_W_b.inverse() * T_W_a * sample.point));
  return min_extent;
}

/// Slides a stone over the table against another: `from` it (unit, level), as it lies or tilted by some rad.
void push_against(SimulatedCell& world, const ShapeList& shapes, StoneIndex stone, StoneIndex other,
                  const Eigen::Vector3d& from, double tilt = 0.0) {
  const Truth truth = world.truth();
  const auto pose = [&](StoneIndex k) { return at(truth.T_W_O, k); };
  const auto& moved = *at(shapes, stone);
  const auto& base = *at(shapes, other);
  const Eigen::Vector3d p_W_base = pose(other) * base.mass.p_O_M;
  for (double away = 0.2; away > 0.0; away -= 0.0005) {
    Pose T_W_O = pose(stone);
    const Eigen::Vector3d p_W_M = T_W_O * moved.mass.p_O_M;
    T_W_O = Eigen::Translation3d(p_W_M) * Eigen::AngleAxisd(tilt, from.cross(Eigen::Vector3d::UnitZ())) *
            Eigen::Translation3d(-p_W_M) * T_W_O;
    double low = 1.0;
    for (const auto& v : moved.scan.vertices) low = std::min(low, (T_W_O * v).z());
    T_W_O.pretranslate(Eigen::Vector3d(0, 0, 0.0005 - low));
    const Eigen::Vector3d shift = p_W_base + away * from - T_W_O * moved.mass.p_O_M;
    T_W_O.pretranslate(Eigen::Vector3d(shift.x(), shift.y(), 0.0));
    if (gap(moved, T_W_O, base, pose(other)) > 0.001) continue;
    world.place(stone, T_W_O);
    return;
  }
}

struct Pushed {
  RunResult result;
  std::string message;
  bool pushed = false;
  std::vector<std::string> decisions;  ///< in its saved states
};

/// Builds with two stones; the second is slid against the first once that stands, and may fall against it.
Pushed build_and_push(const char* name, const Eigen::Vector3d& from, double tilt = 0.0) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const ShapeList shapes = make_contact_shapes(catalogue.stones);
  const RobotModel robot = read_robot("ur10");
  SimulationOptions world_options;
  world_options.seed = 7;
  SimulatedCell world(catalogue.stones, {1_stone, 2_stone}, robot, CellLayout{}, world_options);
  Pushed run;
  BuildHooks hooks;
  hooks.listener = [&](const Event& event) {
    if (run.pushed || !test::is_placed(event)) return;
    run.pushed = true;
    const StoneIndex base = catalogue.index(std::get<PlacementJudged>(event).record.stone);
    push_against(world, shapes, base == 1_stone ? 2_stone : 1_stone, base, from, tilt);
  };
  BuildOptions options;
  options.search.horizon = 1;
  options.save_states = true;
  hooks.states_folder = test::states_folder(test::temporary_folder(), name);
  options.search.friction = options.max_friction;
  Cell cell = world.cell();
  run.result = build_tower(cell, catalogue, robot, options, hooks);
  run.message = test::words(run.result.events, catalogue);
  run.decisions = test::decisions(hooks.states_folder, catalogue, robot);
  return run;
}

bool set_down_one(const RunResult& result) {
  return std::any_of(result.placements.begin(), result.placements.end(), [](const auto& record) {
    return record.outcome == PlacementRecord::Outcome::kUnstacked;
  });
}

TEST(ClearBase, AStoneThatLeansOnTheTowerIsPulledBackAndBuiltOn) {
  const Pushed run =
      build_and_push("clear_base", -Eigen::Vector3d::UnitX());  // the side that the robot can reach
  EXPECT_TRUE(run.pushed);
  ASSERT_FALSE(all_of<StoneLeans>(run.result.events).empty()) << run.message;
  EXPECT_TRUE(set_down_one(run.result));
  EXPECT_EQ(run.result.height, 2) << run.message;
  EXPECT_THAT(run.decisions, testing::Contains("clear_base"));
}

/// Straight up it would drag along the tower.
TEST(ClearBase, AStoneThatLeansSteeplyIsTakenOutAslant) {
  const Pushed run = build_and_push("clear_steep", -Eigen::Vector3d::UnitX(), 1.2);
  EXPECT_TRUE(run.pushed);
  ASSERT_FALSE(all_of<StoneLeans>(run.result.events).empty()) << run.message;
  EXPECT_TRUE(all_of<MotionRefused>(run.result.events).empty()) << run.message;
  EXPECT_TRUE(set_down_one(run.result));
  EXPECT_EQ(run.result.height, 2) << run.message;
}

}  // namespace
}  // namespace stonestack::stacking
