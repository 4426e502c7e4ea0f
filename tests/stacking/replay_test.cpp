#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>

#include "rooms.hpp"
#include "stacking/journal.hpp"
#include "stacking/saved_states.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/scene_tasks.hpp"
#include "temporary_folder.hpp"

namespace stonestack::stacking {
namespace {

using namespace simulation;  // the cell that the loop works in here

constexpr std::size_t kMax = std::size_t{1} << 28;

/// A run with two stones in the cell `lab`, whose devices differ from what the planner assumes.
std::string recorded_run() {
  const std::string folder = test::states_folder(test::temporary_folder(), "run");
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  SimulationOptions world_options = options_of_cell("lab");
  world_options.seed = 7;
  SimulatedCell world(catalogue.stones, {1_stone, 2_stone}, robot, CellLayout{}, world_options);
  Journal journal(folder + "/journal.jsonl");
  journal.record("step", R"({"name": "before the loop"})");
  BuildHooks hooks;
  hooks.journal = &journal;
  hooks.states_folder = folder;
  BuildOptions options;
  options.save_states = true;
  Cell cell = world.cell();
  const RunResult result = build_tower(cell, catalogue, robot, options, hooks);
  EXPECT_FALSE(result.placements.empty()) << "else this tests little";
  return folder;
}

void edit(const std::string& path, const std::string& from, const std::string& to) {
  const std::string before = read_file(path, kMax);
  const std::string after =
      std::regex_replace(before, std::regex(from), to, std::regex_constants::format_first_only);
  ASSERT_NE(after, before) << path;
  write_file(path, after);
}

std::string error_of(const std::string& run) {
  try {
    (void)replay_run({run, "", ""});
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

TEST(Replay, MakesTheSameDecisionsToTheLastDigit) {
  const std::string run = recorded_run();
  const Replay same = replay_run({run, "", ""});
  EXPECT_EQ(same.difference, "");
  EXPECT_TRUE(same.complete);
  EXPECT_GT(same.recorded, 20);
  EXPECT_EQ(same.same, same.recorded);
  EXPECT_THAT(replay_text(same), testing::StartsWith("the same: "));

  // Killed in its middle: what is recorded comes again.
  const std::string answers = run + "/inputs/answers.jsonl", whole = read_file(answers, kMax);
  write_file(answers, whole.substr(0, whole.size() / 2));
  const Replay torn = replay_run({run, "", ""});
  EXPECT_FALSE(torn.complete);
  EXPECT_EQ(torn.difference, "");
  EXPECT_GT(torn.same, 5);
  EXPECT_LT(torn.same, torn.recorded);
  write_file(answers, whole);

  // What a device cannot have answered is refused before anything is performed.
  const std::string depth = run + "/inputs/depth-001.f32", image = read_file(depth, kMax);
  write_file(depth, image.substr(0, image.size() / 2));
  EXPECT_THAT(error_of(run), testing::HasSubstr("depth-001.f32 has"));
  write_file(depth, image);
  edit(answers, R"re("follow":\[0)re", R"("follow":[9)");
  EXPECT_THAT(error_of(run), testing::HasSubstr("no status is 9"));
  write_file(answers, whole);
  edit(answers, R"re("carry":\[0)re", R"("carry":[9)");
  EXPECT_THAT(error_of(run), testing::HasSubstr("no status is 9"));
  write_file(answers, whole);

  // Another journal and other options are told of.
  const std::string journal = run + "/journal.jsonl", kept = read_file(journal, kMax);
  edit(journal, R"re("name":"open the gripper")re", R"("name":"close the gripper")");
  const Replay other = replay_run({run, "", ""});
  EXPECT_THAT(other.difference,
              testing::AllOf(testing::HasSubstr("recorded: "), testing::HasSubstr("close the"),
                             testing::HasSubstr("open the")));
  EXPECT_LT(other.same, other.recorded);
  write_file(journal, kept);
  edit(run + "/inputs/state.json", R"re("options": \{)re", R"("options": {"search.horizon": 1, )");
  EXPECT_NE(replay_run({run, "", ""}).difference, "");
}

TEST(Replay, TellsWhatIsNoRecord) {
  const std::string folder = test::temporary_folder() + "no_record";
  EXPECT_THAT(error_of(folder), testing::HasSubstr("no_record: is no folder"));
  write_file(folder + "/journal.jsonl", "");
  EXPECT_THAT(error_of(folder), testing::HasSubstr("record one with `run --set run.save_states=true`"));
  write_file(folder + "/inputs/answers.jsonl", "");
  EXPECT_THAT(error_of(folder), testing::HasSubstr("no_record/inputs/start.json"));
  write_file(folder + "/inputs/start.json", "{}");
  EXPECT_THAT(error_of(folder), testing::HasSubstr("is no start of a run"));
}

}  // namespace
}  // namespace stonestack::stacking
