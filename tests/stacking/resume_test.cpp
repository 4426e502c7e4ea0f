#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "rooms.hpp"
#include "stacking/learn.hpp"
#include "stacking/mortal_devices.hpp"
#include "stacking/resume_point.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "temporary_folder.hpp"

/// Runs whose program ends in the midst of a step, and that go on.
namespace stonestack::stacking {
namespace {

using namespace simulation;  // the cell that the loop works in here
using nlohmann::json;
using test::Killed;
using test::MortalArm;
using test::MortalGripper;
using testing::HasSubstr;

/// Two stones, and a folder in which the run and its cell are kept.
struct KilledRun {
  Catalogue catalogue = read_catalogue(data_path("stones"));
  RobotModel robot = read_robot("ur10");
  BuildOptions options;
  SimulationOptions world_options;
  std::string folder;
  std::function<void(SimulatedCell&)> meanwhile;  ///< what happens before the program goes on
  std::unique_ptr<SimulatedCell> world;

  explicit KilledRun(const std::string& name) : folder(test::temporary_folder() + name) {
    world_options.seed = 7;
    options.search.horizon = 1;
    options.max_stones = 2;
  }
  void make_world(bool goes_on) {
    world.reset();
    world = std::make_unique<SimulatedCell>(catalogue.stones, std::vector{1_stone, 2_stone}, robot,
                                            CellLayout{}, world_options, goes_on ? folder : std::string());
    world->keep_in(folder);
  }
  /// Begins the run, or goes on with it, until the `count`th command of a step whose name begins so is given;
  /// empty: to its end. True if it was killed.
  bool perform(bool goes_on, const std::string& step, bool before_it, RunResult* result = nullptr,
               int count = 1) {
    make_world(goes_on);
    if (goes_on && meanwhile) meanwhile(*world);
    const Cell devices = world->cell();
    MortalArm arm(devices.arm);
    MortalGripper gripper(devices.gripper);
    Cell cell{arm, gripper, devices.force_torque, devices.camera, devices.clock, devices.layout};
    Journal journal(folder + "/journal.jsonl");
    const auto nothing = [] {};
    const auto die = [&] {
      if (!step.empty() && journal.step().rfind(step, 0) == 0 && --count <= 0) throw Killed();
    };
    arm.before = gripper.before = before_it ? std::function<void()>(die) : nothing;
    arm.after = gripper.after = before_it ? std::function<void()>(nothing) : die;
    BuildHooks hooks;
    hooks.journal = &journal;
    try {
      RunResult done = build_resumable(cell, catalogue, robot, options, hooks, folder, goes_on);
      if (result != nullptr) *result = std::move(done);
      return false;
    } catch (const Killed&) {
      return true;
    }
  }
  [[nodiscard]] std::vector<json> journal() const {
    std::vector<json> lines;
    std::istringstream in(read_file(folder + "/journal.jsonl", 1 << 24));
    for (std::string line; std::getline(in, line);) {
      EXPECT_FALSE(is_damaged(line));
      lines.push_back(json::parse(line));
    }
    return lines;
  }
  /// The run is whole: nothing lost, nothing doubled.
  void expect_tower(const RunResult& result) const {
    EXPECT_EQ(result.end, RunEnd::kAllPlaced) << result.ended;
    EXPECT_EQ(result.height, 2);
    std::set<std::string> placed;
    for (const PlacementRecord& record : result.placements) {
      EXPECT_EQ(record.outcome, PlacementRecord::Outcome::kPlaced) << record.stone << ": " << record.note;
      EXPECT_TRUE(placed.insert(record.stone).second) << record.stone << " is recorded twice";
    }
    EXPECT_EQ(placed.size(), 2U);
    const auto lines = journal();
    std::size_t outcomes = 0;
    for (std::size_t k = 0; k < lines.size(); ++k) {
      EXPECT_EQ(lines[k].at("seq").get<std::size_t>(), k);
      outcomes += lines[k].at("kind") == "outcome" ? 1 : 0;
    }
    EXPECT_EQ(outcomes, 2U);
    const Truth truth = world->truth();
    for (const StoneEstimate& stone : result.world.stack)
      EXPECT_LT(difference(stone.T_W_O_at_rest, at(truth.T_W_O, stone.stone)).translation, 0.005);
  }
};

struct Death {
  const char* name;
  const char* step;  ///< how the name of the step begins
  bool before;       ///< its first command; else after that
  int count = 1;
};
class ResumeAt : public testing::TestWithParam<Death> {};

TEST_P(ResumeAt, EndsWithTheTower) {
  const Death& death = GetParam();
  KilledRun run(std::string("killed_") + death.name);
  ASSERT_TRUE(run.perform(false, death.step, death.before, nullptr, death.count)) << "there is no such step";
  RunResult result;
  ASSERT_FALSE(run.perform(true, "", false, &result));
  run.expect_tower(result);
}

INSTANTIATE_TEST_SUITE_P(
    Steps, ResumeAt,
    testing::Values(Death{"before_anything", "move to a view", true}, Death{"approached", "approach", false},
                    Death{"grasped", "grasp", false}, Death{"lifted", "lift", false},
                    Death{"carried", "carry", false}, Death{"on_the_tower", "set", false, 2},
                    Death{"let_go", "let go", false, 2}, Death{"opened", "open the gripper", false, 3},
                    Death{"retreated", "retreat", false}),
    [](const auto& one) { return std::string(one.param.name); });

TEST(Resume, AProgramThatEndsWhileItTakesAStoneBackGoesOn) {
  KilledRun run("twice");
  ASSERT_TRUE(run.perform(false, "carry", false));
  ASSERT_TRUE(run.perform(true, "take", false));
  ASSERT_TRUE(run.perform(true, "set", false));
  RunResult result;
  ASSERT_FALSE(run.perform(true, "", false, &result));
  run.expect_tower(result);
}

TEST(Resume, AStoneThatWasMovedMeanwhileIsTakenFromWhereItLies) {
  KilledRun run("resume_moved");
  run.options.max_stones = 1;
  ASSERT_TRUE(run.perform(false, "open the gripper", true));
  run.meanwhile = [](SimulatedCell& world) {
    const Truth truth = world.truth();
    for (const StoneIndex stone : {1_stone, 2_stone}) {
      Pose T_W_O = at(truth.T_W_O, stone);
      T_W_O.translation().x() += 0.05;
      world.place(stone, T_W_O);
    }
    world.wait(1.0);
  };
  RunResult result;
  ASSERT_FALSE(run.perform(true, "", true, &result));
  EXPECT_EQ(result.height, 1) << result.ended;
  for (const PlacementRecord& record : result.placements)
    EXPECT_NE(record.outcome, PlacementRecord::Outcome::kNotPicked) << "taken from where it lay before";
}

TEST(Resume, AStoneInAGripperFarFromItsPathIsLeftToAPerson) {
  KilledRun run("beside");
  ASSERT_TRUE(run.perform(false, "carry", false));
  const std::string path = run.folder + "/resume.json";
  json point = json::parse(read_file(path, 1 << 26));
  for (json& step : point.at("motion"))
    for (json& q : step.at("q")) q = q.get<double>() + 0.1;
  write_file(path, point.dump());
  RunResult result;
  ASSERT_FALSE(run.perform(true, "", false, &result));
  EXPECT_EQ(result.end, RunEnd::kStopped);
  EXPECT_THAT(result.ended,
              HasSubstr("out of the gripper and open it, put the stone into the field, then resume"));
}

/// A point of a run, without a cell.
struct Written {
  Catalogue catalogue = read_catalogue(data_path("stones"));
  RobotModel robot = read_robot("ur10");
  BuildOptions options;
  Models models = make_models(catalogue, robot, CellLayout{});
  StageSeconds seconds{1.0, 2.0, 3.0, 4.0, 5.0};
  std::string folder;
  WorldEstimate world;
  RunMemory memory = make_memory(options);
  MotionPlan plan;

  explicit Written(const std::string& name) : folder(test::temporary_folder() + name) {
    world.loose = {{2_stone, make_pose({0.7, -0.2, 0.04}), make_pose({0.7, -0.2, 0.04})}};
    plan.placement.stone = 2_stone;
    plan.placement.T_W_O = make_pose({0.7, 0.28, 0.04});
    PlanStep lift;
    lift.kind = PlanStep::Kind::kLift;
    lift.name = "lift it";
    lift.trajectory = {
        {0.0, 0.5}, {Joints::Zero(), Joints::Constant(0.25)}, {Joints::Zero(), Joints::Zero()}};
    lift.threshold = 7.0;
    plan.pick_and_place.steps = {lift};
    plan.pick_and_place.T_O_T = make_pose({0.0, 0.0, 0.01});
  }
  /// Memory of placing the stone, with that end.
  [[nodiscard]] RunMemory after(ExecutionResult::Status status) const {
    ExecutionResult done;
    done.status = status;
    return remember(memory, world, Place{{plan.placement}}, plan, done);
  }
  [[nodiscard]] ResumeWriter writer(const Journal* journal) const {
    return {folder, models, options, seconds, journal};
  }
};

TEST(ResumePoint, AMotionThatWasBegunIsReadBack) {
  Written w("begun");
  Journal journal(w.folder + "/journal.jsonl");
  w.writer(&journal).begin();
  EXPECT_FALSE(read_resume_point(w.folder, w.catalogue).state);
  journal.record("step", "{}");
  w.writer(&journal).acting(w.world, w.after(ExecutionResult::Status::kUnknown), w.plan);
  const ResumePoint point = read_resume_point(w.folder, w.catalogue);
  EXPECT_EQ(point.lines, 1);
  EXPECT_EQ(point.seconds.motion, 4.0);
  ASSERT_TRUE(point.state && point.motion && point.state->memory.attempt);
  const Attempt& attempt = *point.state->memory.attempt;
  EXPECT_TRUE(std::holds_alternative<Place>(attempt.action));
  EXPECT_EQ(attempt.done.status, ExecutionResult::Status::kUnknown);
  EXPECT_EQ(attempt.placement.stone, 2_stone);
  EXPECT_EQ(attempt.expected_stack.size(), 1U);
  EXPECT_EQ(attempt.expected_loose.size(), 1U) << "it may be at either end";
  ASSERT_EQ(point.motion->steps.size(), 1U);
  const PlanStep& lift = point.motion->steps[0];
  EXPECT_EQ(lift.kind, PlanStep::Kind::kLift);
  EXPECT_EQ(lift.name, "lift it");
  EXPECT_EQ(lift.threshold, 7.0);
  EXPECT_EQ(lift.trajectory.q.back(), Joints::Constant(0.25));
}

TEST(ResumePoint, LinesOfAnObservationAreInTheJournalOnceWhereverTheProgramEnds) {
  for (const int written : {0, 1, 2}) {
    Written w(concat("learned_", written));
    Journal journal(w.folder + "/journal.jsonl");
    journal.record("step", "{}");
    PlacementRecord placed;
    placed.stone = "limestone_2";
    const std::vector<Event> learned{Observed{w.world}, SearchProgress{"for the log only"},
                                     PlacementJudged{placed}};
    w.writer(&journal).observed(w.world, w.memory, learned);
    int left = written;
    for (const Event& event : learned)
      if (const auto [kind, data] = to_record(event, w.catalogue); !kind.empty() && left-- > 0)
        journal.record(kind, data);
    const ResumePoint point = read_resume_point(w.folder, w.catalogue);
    complete_journal(journal, point);
    EXPECT_EQ(journal.lines(), 3) << written << " lines were written";
    complete_journal(journal, point);
    EXPECT_EQ(journal.lines(), 3) << "once is enough";
  }
}

TEST(ResumePoint, ADamagedFileIsRefusedWithARemedy) {
  Written w("none");
  const auto problem = [&] {
    try {
      (void)read_resume_point(w.folder, w.catalogue);
    } catch (const FileError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(problem(), HasSubstr("resume.json"));
  w.writer(nullptr).acting(w.world, w.after(ExecutionResult::Status::kUnknown), w.plan);
  EXPECT_EQ(problem(), "");
  const std::string path = w.folder + kResumeFile, whole = read_file(path, 1 << 24);
  write_file(path, whole.substr(0, whole.size() / 2));
  EXPECT_THAT(problem(), HasSubstr("is not what a run wrote that can go on"));
  std::string other = whole;
  other.replace(other.find("stonestack.resume/1"), 19, "stonestack.resume/9");
  write_file(path, other);
  EXPECT_THAT(problem(), HasSubstr("its schema is not stonestack.resume/1"));
  other = whole;
  const std::string& name = w.catalogue[2_stone].name;
  while (other.find(name) != std::string::npos) other.replace(other.find(name), name.size(), "pumice");
  write_file(path, other);
  EXPECT_THAT(problem(), HasSubstr("pumice")) << "a stone of another catalogue";
}

/// The memory once the stone was seen at `T_W_O`, in the stack or not.
RunMemory judged(const Written& w, ExecutionResult::Status status, const Pose& T_W_O, bool in_stack) {
  WorldEstimate seen;
  (in_stack ? seen.stack : seen.loose) = {{2_stone, T_W_O, T_W_O}};
  return learn(w.after(status), seen, w.models, w.options, {});
}

TEST(BrokenOff, TheNextViewDecidesWhatBecameOfTheStone) {
  using Status = ExecutionResult::Status;
  Written w("judged");
  const Pose& meant = w.plan.placement.T_W_O;
  const RunMemory placed = judged(w, Status::kUnknown, meant, true);
  ASSERT_EQ(placed.records.size(), 1U);
  EXPECT_EQ(placed.records[0].outcome, PlacementRecord::Outcome::kPlaced);
  EXPECT_EQ(placed.records[0].level, 1);
  EXPECT_EQ(placed.failures, 0);
  EXPECT_EQ(placed.actions, 1);

  const RunMemory untouched = judged(w, Status::kUnknown, make_pose({0.71, -0.2, 0.04}), false);
  EXPECT_TRUE(untouched.records.empty()) << "it lies where it lay: nothing was done";
  EXPECT_EQ(untouched.actions, 0);
  EXPECT_EQ(untouched.failures, 0);

  const Pose beside = make_pose({0.7, 0.15, 0.04});
  const RunMemory fallen = judged(w, Status::kUnknown, beside, false);
  ASSERT_EQ(fallen.records.size(), 1U);
  EXPECT_EQ(fallen.records[0].outcome, PlacementRecord::Outcome::kFallen);
  EXPECT_EQ(fallen.failures, 1);
  EXPECT_EQ(fallen.friction.weights, w.memory.friction.weights)
      << "nobody knows whether it was let go of there";

  EXPECT_TRUE(judged(w, Status::kTakenBack, beside, false).records.empty()) << "it was set down on purpose";
}

}  // namespace
}  // namespace stonestack::stacking
