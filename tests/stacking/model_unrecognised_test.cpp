#include "stacking/model_unrecognised.hpp"

#include <gtest/gtest.h>

#include "rooms.hpp"
#include "stacking/heard.hpp"
#include "stacking/resume_point.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/simulation/simulated_cell.hpp"

/// Runs whose stones nobody scanned, with a model that does not show what lies there.
namespace stonestack::stacking {
namespace {

using namespace simulation;

/// Two stones and a foreign object lie in the field. The program knows the first stone, the foreign object
/// from its first look, and a stone that is nowhere.
struct WrongModel {
  Catalogue truth = read_catalogue(data_path("stones"));
  RobotModel robot = read_robot("ur10");
  SimulatedCell world;
  Catalogue known;
  std::vector<Stone> modelled;
  RunResult result;

  explicit WrongModel(bool unseen)
      : world(truth.stones, {1_stone, 3_stone}, robot, CellLayout{}, simulation()) {
    known.path = truth.path;
    known.stones = {truth[1_stone], truth[5_stone]};
    known.stones[1].name = "stone_2";
    Cell cell = world.cell();
    BuildOptions options;
    options.unseen = unseen;
    options.search.horizon = 2;
    result = build_resumable(cell, known, robot, options, {}, {}, false,
                             [&](const Stone& stone, const ModelledStone&) { modelled.push_back(stone); });
  }
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
  const auto told = all_of<StoneModelled>(run.result.events);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].lost, std::vector<StoneIndex>{1_stone});
  EXPECT_NEAR(run.modelled[0].mass.mass, run.known.stones[1].mass.mass, 1e-9) << "of the one that is lost";
  EXPECT_NEAR(volume(run.modelled[0].scan), volume(run.truth[3_stone].scan),
              0.3 * volume(run.truth[3_stone].scan));
  bool handled = false;
  for (const PlacementRecord& record : run.result.placements) handled |= record.stone == "stone_3";
  EXPECT_TRUE(handled) << run.story();
}

TEST(ModelUnrecognised, NotWhereTheStonesWereScanned) {
  const WrongModel run(false);
  EXPECT_TRUE(run.modelled.empty());
  EXPECT_TRUE(all_of<StoneModelled>(run.result.events).empty());
  EXPECT_EQ(run.result.height, 1);
}

}  // namespace
}  // namespace stonestack::stacking
