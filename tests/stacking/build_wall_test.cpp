#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stacking/choose_action.hpp"
#include "stacking/saved_states.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"
#include "temporary_folder.hpp"

namespace stonestack::stacking {
namespace {

using namespace simulation;  // the cell that the loop works in here

/// A run that builds 2 + 1 of the stones that come with stonestack, with the states before its decisions.
struct WallRun {
  Catalogue catalogue = read_catalogue(data_path("stones"));
  RobotModel robot = read_robot("ur10");
  std::string states = test::states_folder(test::temporary_folder(), "wall");
  std::unique_ptr<SimulatedCell> world;
  RunResult result;

  WallRun() {
    SimulationOptions truth;
    truth.seed = 3;
    world = std::make_unique<SimulatedCell>(catalogue.stones,
                                            std::vector<StoneIndex>{0_stone, 1_stone, 4_stone, 5_stone},
                                            robot, CellLayout{}, truth);
    BuildOptions options;
    options.wall = "2+1";
    options.save_states = true;
    Cell cell = world->cell();
    BuildHooks hooks;
    hooks.states_folder = states;
    result = build_tower(cell, catalogue, robot, options, hooks);
  }
};

/// The state before the last decision with `standing` stones in the wall.
State state_with(const WallRun& run, std::size_t standing) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(run.states))
    if (entry.is_regular_file()) files.push_back(entry.path().string());
  std::sort(files.rbegin(), files.rend());
  for (const std::string& file : files)
    if (State state = read_state(file, run.catalogue); state.world.stack.size() == standing) return state;
  throw InvalidArgument(concat("no state with ", standing, " stones in the wall"));
}

/// Expects the second stone to be taken off where both came to rest beside the axis: none can lie on them.
void expect_second_is_taken_off(const WallRun& run) {
  State state = state_with(run, 2);
  const Eigen::Vector3d across = state.memory.wall->T_W_V.linear().col(1);
  for (const auto& [k, shift] : {std::pair{0, 0.14}, {1, -0.14}}) {
    StoneEstimate& stone = state.world.stack[static_cast<std::size_t>(k)];
    stone.T_W_O_seen.pretranslate(shift * across);
    stone.T_W_O_at_rest.pretranslate(shift * across);
  }
  state.memory.plan.reset();
  state.memory.search.reset();
  const Models models = make_models(run.catalogue, run.robot, CellLayout{}, state.options.wall);
  const auto decide = [&] {
    add_resting_stacks(models, state.options, state.memory.friction, state.world);
    return choose_action(state.world, state.memory, models, state.options);
  };
  const Decision decision = decide();
  const auto* unstack = std::get_if<Unstack>(&decision.action);
  ASSERT_NE(unstack, nullptr) << name_of(decision.action);
  EXPECT_EQ(unstack->top.stone, state.world.stack[1].stone);
  const auto chosen = all_of<UnstackChosen>(decision.why);
  ASSERT_EQ(chosen.size(), 1U);
  EXPECT_GT(chosen.front().expected, 2.0) << "more stones than stand";
  State finished = state;
  finished.memory = decision.memory;
  finished.memory.unstacking.reset();
  finished.memory.search->dead_end = Stop{RunEnd::kHeightReached, "the wall stands"};
  const Decision at_end = choose_action(finished.world, finished.memory, models, finished.options);
  EXPECT_EQ(name_of(at_end.action), "stop") << "nothing is taken off what is finished";
  state.options.max_unstacked = 0;
  EXPECT_EQ(name_of(decide().action), "stop");
}

// One test: the run takes a minute.
TEST(BuildWall, PlacesTwoStonesAndAThirdOverTheirJoint) {
  const WallRun run;
  const RunResult& result = run.result;
  ASSERT_EQ(result.end, RunEnd::kHeightReached) << result.ended;
  EXPECT_EQ(result.height, 3);
  ASSERT_TRUE(result.wall.has_value());
  EXPECT_EQ(result.wall->placed, 3);
  EXPECT_EQ(result.wall->asked, 3);
  EXPECT_EQ(result.wall->joints, 1);
  EXPECT_EQ(result.wall->open_joints, 0);
  const std::vector<StoneEstimate>& stack = result.world.stack;
  ASSERT_EQ(stack.size(), 3U);
  const Truth truth = run.world->truth();
  const auto place = [&](std::size_t k) { return at(truth.T_W_O, stack[k].stone).translation(); };
  EXPECT_GT((place(0) - place(1)).head<2>().norm(), 0.06) << "beside each other";
  EXPECT_GT(place(2).z(), std::max(place(0).z(), place(1).z()) + 0.03) << "the third lies on them";
  EXPECT_GT(place(2).x(), std::min(place(0).x(), place(1).x()));
  EXPECT_LT(place(2).x(), std::max(place(0).x(), place(1).x()));
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_LT(difference(at(truth.T_W_O, stack[k].stone), stack[k].T_W_O_at_rest).translation, 0.006);

  std::vector<int> courses;
  for (const PlacementRecord& record : result.placements)
    if (record.outcome == PlacementRecord::Outcome::kPlaced) courses.push_back(record.course);
  EXPECT_THAT(courses, testing::ElementsAre(1, 1, 2));

  std::vector<std::string> in_run;
  for (const ActionChosen& chosen : all_of<ActionChosen>(result.events)) {
    in_run.push_back(name_of(chosen.action));
    if (!std::holds_alternative<Place>(chosen.action)) continue;
    EXPECT_EQ(chosen.others.size(), 5U) << "beside the chosen one, where a plan is followed too";
    for (const Alternative& other : chosen.others)
      EXPECT_TRUE(other.terms.contains("joint_cover") || !other.why_not.empty());
    EXPECT_FALSE(chosen.offered.front().support.corners_W.empty());
  }
  EXPECT_FALSE(all_of<PlanHolds>(result.events).empty());
  EXPECT_EQ(test::decisions(run.states, run.catalogue, run.robot), in_run)
      << "saved states are decided as in the run";
  expect_second_is_taken_off(run);
}

TEST(BuildWall, RefusesAWallThatItCannotRead) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  SimulatedCell world(catalogue.stones, {0_stone}, robot, CellLayout{}, {});
  Cell cell = world.cell();
  BuildOptions options;
  options.wall = "3+x";
  EXPECT_THROW((void)build_tower(cell, catalogue, robot, options), InvalidArgument);
  options.wall = "1";
  options.search.method = "paper";
  EXPECT_THROW((void)build_tower(cell, catalogue, robot, options), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::stacking
