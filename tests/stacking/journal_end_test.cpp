// The journal's last line: how a run ended, and what stopped it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "physics/shape.hpp"
#include "stacking/journal.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"
#include "temporary_folder.hpp"

namespace stonestack::stacking {
namespace {

using namespace simulation;  // the cell that the loop works in here

using nlohmann::json;
using ::testing::HasSubstr;

/// The arm of a simulated cell, whose first motion ends as the test asks.
struct EndingArm : Arm {
  explicit EndingArm(Arm& real) : arm(real) {}
  ArmState state() override { return arm.state(); }
  MotionResult follow(const JointTrajectory&) override { return ends(); }
  MotionResult follow_guarded(const GuardedMotion&) override { return ends(); }
  void stop() override {
    if (dead) throw DeviceError("UR arm at 10.0.0.7", "no data for 0.1 s", "look at the cable");
  }
  void set_payload(double, const Eigen::Vector3d&) override {}

  Arm& arm;
  std::function<MotionResult()> ends;
  bool dead = false;
};

/// Each time that is asked for is a second later.
struct LateClock : Clock {
  mutable std::atomic<int> seconds{0};
  [[nodiscard]] double now() const override { return ++seconds; }
};

struct EndedRun {
  RunResult result;
  std::string thrown;
  json last;  ///< line of the journal
};

/// `interrupted`: before the run begins.
EndedRun run_until(const std::function<MotionResult()>& ends, bool dead = false, bool interrupted = false) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  SimulatedCell world(catalogue.stones, {1_stone}, robot, CellLayout{}, {});
  const Cell real = world.cell();
  EndingArm arm(real.arm);
  arm.ends = ends;
  arm.dead = dead;
  Cell cell{arm, real.gripper, real.force_torque, real.camera, real.clock, real.layout};
  const std::string path = test::temporary_folder() + "journal_end_" +
                           testing::UnitTest::GetInstance()->current_test_info()->name() + ".jsonl";
  std::filesystem::remove(path);
  EndedRun run;
  {
    Journal journal(path);
    BuildHooks hooks;
    hooks.journal = &journal;
    const LateClock clock;
    std::optional<TimeLimit> as_by_a_user;
    if (interrupted) as_by_a_user.emplace(0.5, clock);
    try {
      run.result = build_tower(cell, catalogue, robot, {}, hooks);
    } catch (const std::exception& error) {
      run.thrown = error.what();
    }
  }
  std::string text = read_file(path, 1 << 20);
  EXPECT_FALSE(text.empty());
  if (text.empty()) return run;
  text.pop_back();
  run.last = json::parse(text.substr(text.rfind('\n') + 1));
  std::filesystem::remove(path);
  return run;
}

MotionResult stopped(const std::string& reason) {
  return {MotionResult::Status::kStopped, Joints::Zero(), 0.0, reason};
}

TEST(JournalEnd, NamesTheStop) {
  for (const char* reason :
       {"protective stop (safety 3, bits 0x404)", "emergency stop of the robot (safety 7, bits 0x4c0)",
        "paused by the user (program paused or speed slider at 0) for 300 s",
        "the arm was moved by 0.3 rad while the program was paused"}) {
    const EndedRun run = run_until([&] { return stopped(reason); });
    EXPECT_EQ(run.result.end, RunResult::End::kStopped);
    EXPECT_EQ(run.last["kind"], "end") << reason;
    EXPECT_EQ(run.last["data"]["end"], "stopped") << reason;
    EXPECT_THAT(run.last["data"]["reason"].get<std::string>(), HasSubstr(reason));
  }
}

TEST(JournalEnd, NamesALostLinkAndAnArmThatDoesNotConfirmItsStop) {
  const EndedRun run = run_until(
      []() -> MotionResult {
        throw DeviceError("UR arm at 10.0.0.7", "closed the connection", "look at the controller");
      },
      true);
  EXPECT_EQ(run.thrown, "") << "what was done until then is a result";
  EXPECT_EQ(run.result.end, RunResult::End::kStopped);
  EXPECT_EQ(run.last["kind"], "end");
  const auto reason = run.last["data"]["reason"].get<std::string>();
  EXPECT_EQ(reason, run.result.ended);
  EXPECT_THAT(reason, HasSubstr("closed the connection"));
  EXPECT_THAT(reason, HasSubstr("did not confirm a stop: UR arm at 10.0.0.7: no data"));
}

TEST(JournalEnd, NamesAnInterruption) {
  const EndedRun run = run_until([]() -> MotionResult { throw Interrupted(); });
  EXPECT_EQ(run.last["kind"], "end");
  EXPECT_EQ(run.last["data"]["end"], "interrupted");
}

TEST(JournalEnd, NamesAnInterruptionBeforeTheFirstView) {
  const EndedRun run = run_until([] { return stopped("must not move"); }, false, true);
  EXPECT_EQ(run.thrown, "") << "a run without any stone is a result, too";
  EXPECT_EQ(run.result.end, RunResult::End::kInterrupted);
  EXPECT_EQ(run.result.ended, "interrupted by the user");
  EXPECT_EQ(all_of<RunEnded>(run.result.events).size(), 1U);
  EXPECT_EQ(run.last["kind"], "end");
  EXPECT_EQ(run.last["data"]["end"], "interrupted");
}

TEST(JournalEnd, NamesWhatNobodyForesaw) {
  const EndedRun run = run_until([]() -> MotionResult { throw std::logic_error("a \"defect\" \xff"); });
  EXPECT_THAT(run.thrown, HasSubstr("defect")) << "it is passed on";
  EXPECT_EQ(run.last["kind"], "end");
  EXPECT_EQ(run.last["data"]["end"], "failed");
  EXPECT_THAT(run.last["data"]["reason"].get<std::string>(), HasSubstr("a \"defect\""));
}

}  // namespace
}  // namespace stonestack::stacking
