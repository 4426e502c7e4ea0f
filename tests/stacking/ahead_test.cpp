#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>

#include "stacking/hiding_camera.hpp"
#include "stonestack/core/data.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"

/// What a run thinks of while its arm is on the way to the next look.
namespace stonestack::stacking {
namespace {

using testing::HasSubstr;
using testing::Not;

/// An arm that does something of a test's when it is about to follow its n-th trajectory (from 0).
struct WatchedArm : Arm {
  Arm& arm;
  int count = 0;
  std::atomic<int> stops = 0;
  std::function<std::optional<MotionResult>(int)> before;
  explicit WatchedArm(Arm& a) : arm(a) {}
  ArmState state() override { return arm.state(); }
  MotionResult follow(const JointTrajectory& trajectory) override {
    if (before)
      if (const auto instead = before(count++)) return *instead;
    return arm.follow(trajectory);
  }
  MotionResult follow_guarded(const GuardedMotion& motion) override { return arm.follow_guarded(motion); }
  void stop() override {
    ++stops;
    arm.stop();
  }
  void set_payload(double mass, const Eigen::Vector3d& p_F_com) override { arm.set_payload(mass, p_F_com); }
};

struct Lab {
  Catalogue catalogue = read_catalogue(data_path("stones"));
  RobotModel robot = read_robot("ur10");
  SimulatedCell world;
  Cell cell;
  WatchedArm arm;
  test::HidingCamera camera;
  std::string said;
  std::function<void(const std::string&)> listener;

  explicit Lab(const std::vector<int>& present = {1, 2})
      : world(catalogue.stones, present, robot, CellLayout{}, seeded()),
        cell(world.cell()),
        arm(cell.arm),
        camera(cell, robot) {}
  static SimulationOptions seeded() {
    SimulationOptions options;
    options.seed = 7;
    return options;
  }
  RunResult build(int most_stones) {
    BuildOptions options;
    options.most_stones = most_stones;
    options.search.horizon = 1;
    BuildHooks hooks;
    hooks.report = [this](const std::string& line) {
      said += line + "\n";
      if (listener) listener(line);
    };
    Cell watched{arm, cell.gripper, cell.force_torque, camera, cell.clock, cell.layout};
    return build_tower(watched, catalogue, robot, options, hooks);
  }
  [[nodiscard]] std::string said_between(const std::string& from, const std::string& to) const {
    const auto begin = said.find(from), end = said.find(to, begin);
    EXPECT_NE(begin, std::string::npos) << from << " in\n" << said;
    EXPECT_NE(end, std::string::npos) << to << " in\n" << said;
    return begin == std::string::npos ? "" : said.substr(begin, end - begin);
  }
};

constexpr const char* kSearched = "stones are expected to stand";

TEST(Ahead, TheArmIsOnItsWayWhileItIsSearched) {
  Lab lab;
  std::mutex mutex;
  std::condition_variable changed;
  int searches = 0;
  bool waited_in_vain = false;
  lab.listener = [&](const std::string& line) {
    if (line.find(kSearched) == std::string::npos) return;
    const std::lock_guard lock(mutex);
    ++searches;
    changed.notify_all();
  };
  // The second look is not reached before a search has ended: that comes to nothing unless it runs meanwhile.
  lab.arm.before = [&](int motion) -> std::optional<MotionResult> {
    if (motion != 1) return std::nullopt;
    std::unique_lock lock(mutex);
    waited_in_vain = !changed.wait_for(lock, std::chrono::seconds(60), [&] { return searches > 0; });
    return std::nullopt;
  };
  const RunResult result = lab.build(2);
  EXPECT_FALSE(waited_in_vain) << lab.said;
  EXPECT_EQ(result.height, 2) << lab.said;
  EXPECT_GT(result.seconds.beside_motion, 0.0);
  EXPECT_THAT(lab.said_between("stack: none", "level 1"), Not(HasSubstr("round")))
      << "it is not searched again";
  EXPECT_THAT(lab.said_between("level 1", "placed, "), HasSubstr(kSearched))
      << "the second stone's pose is known before";
  EXPECT_THAT(lab.said_between("placed, ", "level 2"), Not(HasSubstr("round")));
}

TEST(Ahead, OnATowerThatStoodThereBeforeNothingIsSearchedTwice) {
  Lab lab({1, 2, 4});
  ASSERT_EQ(lab.build(1).height, 1) << lab.said;
  lab.said.clear();
  EXPECT_EQ(lab.build(3).height, 3) << lab.said;
  EXPECT_THAT(lab.said_between("level 2", "placed, "), HasSubstr(kSearched));
  EXPECT_THAT(lab.said_between("placed, ", "level 3"), Not(HasSubstr("round")));
}

TEST(Ahead, AStoneThatOnlyTheSecondLookShowsIsSearchedWith) {
  Lab lab;
  lab.camera.only_frame = 0;
  lab.camera.radius = 0.09;
  lab.camera.p_W_hidden = lab.world.truth().T_W_O[1].translation().head<2>();
  const RunResult result = lab.build(2);
  EXPECT_EQ(result.height, 2) << lab.said;
  EXPECT_THAT(lab.said_between("", "camera mount"), HasSubstr(kSearched)) << "by what the first look showed";
  EXPECT_THAT(lab.said_between("stack: none; loose: limestone_2, limestone_3", "level 1"),
              HasSubstr(kSearched));
}

TEST(Ahead, CtrlCStopsTheArmBeforeTheSearchHasEnded) {
  Lab lab;
  int stops_at_search = -1;
  lab.listener = [&](const std::string& line) {
    if (line.find(kSearched) != std::string::npos) stops_at_search = lab.arm.stops;
  };
  lab.arm.before = [&](int motion) -> std::optional<MotionResult> {
    if (motion == 1) throw Interrupted();
    return std::nullopt;
  };
  const RunResult result = lab.build(2);
  EXPECT_EQ(result.end, RunResult::End::kInterrupted);
  EXPECT_GE(stops_at_search, 1) << lab.said;
}

TEST(Ahead, AnArmThatStopsOnItsWayEndsTheRun) {
  Lab lab;
  int motions = 0;
  lab.arm.before = [&](int motion) -> std::optional<MotionResult> {
    motions = motion + 1;
    if (motion != 1) return std::nullopt;
    return MotionResult{MotionResult::Status::kStopped, Joints::Zero(), 0.0, "somebody stood in the way"};
  };
  const RunResult result = lab.build(2);
  EXPECT_EQ(result.end, RunResult::End::kStopped);
  EXPECT_THAT(result.ended, HasSubstr("somebody stood in the way"));
  EXPECT_EQ(motions, 2) << "nothing moves after that";
}

}  // namespace
}  // namespace stonestack::stacking
