#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>

#include "stacking/heard.hpp"
#include "stacking/hiding_camera.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"

/// The action that a run chooses for the predicted world while its arm moves to the next view.
namespace stonestack::stacking {
namespace {

using namespace simulation;  // the cell that the loop works in here

using testing::HasSubstr;

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
  std::vector<Event> heard;
  Listener listener;

  explicit Lab(const std::vector<StoneIndex>& present = {StoneIndex{1}, StoneIndex{2}})
      : world(catalogue.stones, present, robot, CellLayout{}, seeded()),
        cell(world.cell()),
        arm(cell.arm),
        camera(cell, robot) {}
  static SimulationOptions seeded() {
    SimulationOptions options;
    options.seed = 7;
    return options;
  }
  RunResult build(int max_stones) {
    BuildOptions options;
    options.max_stones = max_stones;
    options.search.horizon = 1;
    BuildHooks hooks;
    hooks.listener = [this](const Event& event) {
      heard.push_back(event);
      if (listener) listener(event);
    };
    Cell watched{arm, cell.gripper, cell.force_torque, camera, cell.clock, cell.layout};
    return build_tower(watched, catalogue, robot, options, hooks);
  }
  [[nodiscard]] std::string message() const { return test::words(heard, catalogue); }
  using Is = std::function<bool(const Event&)>;
  /// From the first event that is `from` to the next that is `to`.
  [[nodiscard]] std::vector<Event> heard_between(const Is& from, const Is& to) const {
    const auto begin = std::find_if(heard.begin(), heard.end(), from);
    const auto end = std::find_if(begin, heard.end(), to);
    EXPECT_NE(begin, heard.end()) << message();
    EXPECT_NE(end, heard.end()) << message();
    return {begin, end};
  }
};

/// A search has found something.
bool is_found(const Event& event) {
  const auto* searched = std::get_if<SearchedAtFriction>(&event);
  return searched != nullptr && searched->found;
}
bool any_found(const std::vector<Event>& events) {
  return std::any_of(events.begin(), events.end(), is_found);
}
/// Is anything searched, and not only found to hold still?
bool any_search(const std::vector<Event>& events) {
  return !all_of<SearchProgress>(events).empty();
}
bool is_first(const Event& /*event*/) {
  return true;
}
bool is_observed(const Event& event) {
  return std::holds_alternative<Observed>(event);
}
Lab::Is is_level(int level) {
  return [level](const Event& event) {
    const auto* begun = std::get_if<PlaceBegun>(&event);
    return begun != nullptr && begun->level == level;
  };
}

TEST(Ahead, TheArmMovesWhileItIsSearched) {
  Lab lab;
  std::mutex mutex;
  std::condition_variable changed;
  int searches = 0;
  bool waited_in_vain = false;
  lab.listener = [&](const Event& event) {
    if (!is_found(event)) return;
    const std::lock_guard lock(mutex);
    ++searches;
    changed.notify_all();
  };
  // The second view is not reached before a search has ended: that comes to nothing unless it runs meanwhile.
  lab.arm.before = [&](int motion) -> std::optional<MotionResult> {
    if (motion != 1) return std::nullopt;
    std::unique_lock lock(mutex);
    waited_in_vain = !changed.wait_for(lock, std::chrono::seconds(60), [&] { return searches > 0; });
    return std::nullopt;
  };
  const RunResult result = lab.build(2);
  EXPECT_FALSE(waited_in_vain) << lab.message();
  EXPECT_EQ(result.height, 2) << lab.message();
  EXPECT_GT(result.seconds.beside_motion, 0.0);
  EXPECT_FALSE(any_search(lab.heard_between(is_observed, is_level(1)))) << "it is not searched again";
  EXPECT_TRUE(any_found(lab.heard_between(is_level(1), test::is_placed)))
      << "the second stone's pose is known before";
  EXPECT_FALSE(any_search(lab.heard_between(test::is_placed, is_level(2))));
}

TEST(Ahead, OnATowerThatStoodThereBeforeNothingIsSearchedTwice) {
  Lab lab({1_stone, 2_stone, 4_stone});
  ASSERT_EQ(lab.build(1).height, 1) << lab.message();
  lab.heard.clear();
  EXPECT_EQ(lab.build(3).height, 3) << lab.message();
  EXPECT_TRUE(any_found(lab.heard_between(is_level(2), test::is_placed)));
  EXPECT_FALSE(any_search(lab.heard_between(test::is_placed, is_level(3))));
}

TEST(Ahead, AStoneThatOnlyTheSecondViewShowsIsSearchedWith) {
  Lab lab;
  lab.camera.only_frame = 0;
  lab.camera.radius = 0.09;
  lab.camera.p_W_hidden = lab.world.truth().T_W_O[1].translation().head<2>();
  const RunResult result = lab.build(2);
  EXPECT_EQ(result.height, 2) << lab.message();
  const auto is_refined = [](const Event& event) { return std::holds_alternative<CameraRefined>(event); };
  EXPECT_TRUE(any_found(lab.heard_between(is_first, is_refined))) << "by what the first view showed";
  const auto sees_both = [](const Event& event) {
    const auto* seen = std::get_if<Observed>(&event);
    return seen != nullptr && seen->world.stack.empty() && seen->world.loose.size() == 2;
  };
  EXPECT_TRUE(any_found(lab.heard_between(sees_both, is_level(1))));
}

TEST(Ahead, CtrlCStopsTheArmBeforeTheSearchHasEnded) {
  Lab lab;
  int stops_at_search = -1;
  lab.listener = [&](const Event& event) {
    if (is_found(event)) stops_at_search = lab.arm.stops;
  };
  lab.arm.before = [&](int motion) -> std::optional<MotionResult> {
    if (motion == 1) throw Interrupted();
    return std::nullopt;
  };
  const RunResult result = lab.build(2);
  EXPECT_EQ(result.end, RunResult::End::kInterrupted);
  EXPECT_GE(stops_at_search, 1) << lab.message();
}

TEST(Ahead, AnArmThatStopsOnItsRouteEndsTheRun) {
  Lab lab;
  int motions = 0;
  lab.arm.before = [&](int motion) -> std::optional<MotionResult> {
    motions = motion + 1;
    if (motion != 1) return std::nullopt;
    return MotionResult{MotionResult::Status::kStopped, Joints::Zero(), 0.0, "a person was in the workspace"};
  };
  const RunResult result = lab.build(2);
  EXPECT_EQ(result.end, RunResult::End::kStopped);
  EXPECT_THAT(result.ended, HasSubstr("a person was in the workspace"));
  EXPECT_EQ(motions, 2) << "nothing moves after that";
}

}  // namespace
}  // namespace stonestack::stacking
