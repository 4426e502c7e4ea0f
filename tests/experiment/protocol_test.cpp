#include <gtest/gtest.h>

#include <algorithm>

#include "stacking/choose_action.hpp"
#include "stacking/learn.hpp"
#include "stacking/state_file.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/experiment/simulated_run.hpp"
#include "stonestack/kinematics/robot_model.hpp"

/// When a run ends.
namespace stonestack::experiment {
namespace {

using Outcome = PlacementRecord::Outcome;

SimulatedRun with_protocol(const std::string& protocol) {
  SimulatedRun run;
  apply_protocol(run, protocol);
  return run;
}

TEST(Protocol, FullChangesNothingAndOthersAreRefused) {
  SimulatedRun usual, full = with_protocol("full");
  EXPECT_EQ(write_fields(fields(full)), write_fields(fields(usual)));
  EXPECT_THROW((void)with_protocol("short"), InvalidArgument);
}

/// A decision that a run saved, made again by the paper's protocol.
class SavedDecision {
 public:
  explicit SavedDecision(const std::string& name)
      : state_(read_state(concat(STONESTACK_SOURCE_DIR, "/tests/data/states/", name, ".json"), catalogue_)) {}

  [[nodiscard]] Decision choose(const std::string& protocol, int pushed = 0) {
    SimulatedRun run;
    run.build = state_.options;
    apply_protocol(run, protocol);
    WorldEstimate world = state_.world;
    add_resting_stacks(models_, run.build, state_.memory.friction, world);
    RunMemory memory = state_.memory;
    memory.search.reset();  // that of the run which saved the state, by the full protocol
    memory.plan.reset();
    memory.pushed = pushed;
    return choose_action(world, memory, models_, run.build);
  }

 private:
  Catalogue catalogue_ = read_catalogue(data_path("stones"));
  RobotModel robot_ = read_robot("ur10");
  Models models_ = make_models(catalogue_, robot_, CellLayout{});
  State state_;
};

TEST(Protocol, ThePapersPushesAndUnstacksNothing) {
  SavedDecision decision("unstack");
  EXPECT_TRUE(std::holds_alternative<Push>(decision.choose("full").action));
  EXPECT_TRUE(
      std::holds_alternative<Unstack>(decision.choose("full", SimulatedRun{}.build.max_reoriented).action));
  const Action paper = decision.choose("paper").action;
  EXPECT_FALSE(std::holds_alternative<Push>(paper));
  EXPECT_FALSE(std::holds_alternative<Unstack>(paper));
}

TEST(Protocol, ThePapersReorientsNothing) {
  SavedDecision decision("reorient");
  const auto searches_reorienting = [&](const std::string& protocol) {
    const auto searched = all_of<SearchedAtFriction>(decision.choose(protocol).why);
    EXPECT_FALSE(searched.empty()) << protocol;
    return std::any_of(searched.begin(), searched.end(),
                       [](const SearchedAtFriction& search) { return search.route == Route::kReorienting; });
  };
  EXPECT_TRUE(searches_reorienting("full"));
  EXPECT_FALSE(searches_reorienting("paper"));
}

/// Runs over slippery stones: whatever fails first is the last that was tried.
TEST(Protocol, ThePapersRunEndsAtTheFirstPlacementThatFails) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  int failed = 0;
  for (int seed = 1; seed <= 8 && failed == 0; ++seed) {
    SimulatedRun run = with_protocol("paper");
    run.seed = seed;
    run.simulation.friction = 0.06;
    run.simulation.friction_spread = 0.0;
    run.build.search.perturbations = 2;
    run.build.search.horizon = 1;
    run.build.min_expected = 0.0;
    spread_seed(run);
    SimulatedCell world(catalogue.stones, first_stones(3), robot, CellLayout{}, run.simulation);
    Cell cell = world.cell();
    const RunResult result = build_tower(cell, catalogue, robot, run.build);
    const auto& records = result.placements;
    const auto first = std::find_if(records.begin(), records.end(), [](const PlacementRecord& record) {
      return record.outcome != Outcome::kPlaced;
    });
    if (first == records.end()) continue;
    ++failed;
    EXPECT_EQ(first + 1, records.end()) << "seed " << seed;
    EXPECT_EQ(result.end, RunEnd::kPlacementFailed) << result.ended;
    RunReport report;
    report.result = result;
    EXPECT_EQ(paper_height(report), static_cast<int>(records.size()) - 1);
  }
  EXPECT_EQ(failed, 1) << "no placement failed: the cell is too easy for this test";
}

}  // namespace
}  // namespace stonestack::experiment
