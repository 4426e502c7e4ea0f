#include "stacking/model_unrecognised.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "rooms.hpp"
#include "stacking/heard.hpp"
#include "stacking/journal.hpp"
#include "stacking/resume_point.hpp"
#include "stacking/saved_states.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/scene_tasks.hpp"
#include "temporary_folder.hpp"

/// Runs whose stones nobody scanned, with a model that does not show what lies there.
namespace stonestack::stacking {
namespace {

using namespace simulation;

/// Two stones lie in the field. The program has a model of the first, and one of a stone that is nowhere.
struct WrongModel {
  Catalogue truth = read_catalogue(data_path("stones"));
  RobotModel robot = read_robot("ur10");
  SimulatedCell world{truth.stones, {1_stone, 3_stone}, robot, CellLayout{}, simulation()};
  std::string folder = stonestack::test::states_folder(stonestack::test::temporary_folder(), "anew");
  Catalogue known;
  std::vector<Stone> modelled;
  RunResult result;

  explicit WrongModel(bool unseen) {
    std::filesystem::remove_all(stones());
    Stone second = truth[5_stone];
    second.name = "stone_2";
    for (const Stone& stone : {truth[1_stone], second}) write_stone(stones(), stone);
    known = read_catalogue(stones());
    Journal journal(folder + "/journal.jsonl");
    BuildHooks hooks;
    hooks.journal = &journal;
    hooks.states_folder = folder;
    Cell cell = world.cell();
    BuildOptions options;
    options.unseen = unseen;
    options.save_states = true;
    options.search.horizon = 2;
    result = build_resumable(cell, known, robot, options, hooks, {}, false,
                             [&](const Stone& stone, const ModelledStone&) {
                               write_stone(stones(), stone);
                               modelled.push_back(stone);
                             });
  }
  [[nodiscard]] std::string stones() const { return folder + "/stones"; }
  static SimulationOptions simulation() {
    SimulationOptions options;
    options.seed = 5;
    options.clearance = 0.02;
    return options;
  }
  [[nodiscard]] std::string story() const {
    Catalogue all = known;
    all.stones.insert(all.stones.end(), modelled.begin(), modelled.end());
    return stonestack::test::words(result.events, all);
  }
};

TEST(ModelUnrecognised, AStoneThatNoModelShowsBecomesAnotherStoneOfTheRun) {
  const WrongModel run(true);
  ASSERT_EQ(run.modelled.size(), 1U) << run.story();
  EXPECT_EQ(run.modelled[0].name, "stone_3");
  ASSERT_TRUE(run.modelled[0].surface.has_value()) << "most of its underside is a guess, and says so";
  const StoneIndex lost(run.known.index("stone_2"));
  const auto told = all_of<StoneModelled>(run.result.events);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].lost, std::vector<StoneIndex>{lost});
  EXPECT_NEAR(run.modelled[0].mass.mass, run.known[lost].mass.mass, 1e-9) << "of the one that is lost";
  const double volume_is = volume(run.truth[3_stone].scan);
  EXPECT_NEAR(volume(run.modelled[0].scan), volume_is, 0.3 * volume_is);
  bool handled = false;
  for (const PlacementRecord& record : run.result.placements) handled |= record.stone == "stone_3";
  EXPECT_TRUE(handled) << run.story();

  // The catalogue has the new stone now; the run began without it.
  const Replay again = replay_run({run.folder, "", ""});
  EXPECT_EQ(again.difference, "");
  EXPECT_TRUE(again.complete);
  EXPECT_EQ(again.same, again.recorded);
}

TEST(ModelUnrecognised, NotWhereTheStonesWereScanned) {
  const WrongModel run(false);
  EXPECT_TRUE(run.modelled.empty());
  EXPECT_TRUE(all_of<ModellingBegun>(run.result.events).empty());
  EXPECT_EQ(run.result.height, 1);
}

}  // namespace
}  // namespace stonestack::stacking
