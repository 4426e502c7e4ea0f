#include "hardware/hold_watch.hpp"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "hardware/constants.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::hardware {
namespace {

/// Asks the gripper from a thread of its own until the motion is over.
class Watching {
 public:
  Watching(Arm& arm, Gripper& gripper) : arm_(arm), gripper_(gripper), thread_([this] { watch(); }) {}
  ~Watching() { end(); }
  Watching(const Watching&) = delete;
  Watching& operator=(const Watching&) = delete;

  /// Ends the watch. True if the object was lost while the arm moved.
  bool end() {
    {
      const std::lock_guard lock(mutex_);
      over_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
    return lost_;
  }
  /// Why the arm did not confirm the stop; empty: it did, or none was needed. After `end`.
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  void watch() {
    HoldJudge judge;
    do {
      try {
        if (!judge.lost(gripper_.state())) continue;
        if (arm_.state().qd.cwiseAbs().maxCoeff() < kStandstillSpeed) continue;
      } catch (const std::exception& problem) {
        log_debug(std::string("whether the gripper still holds anything is not known: ") + problem.what());
        continue;
      }
      if (!is_over()) stop();
      return;
    } while (!pause());
  }

  void stop() {
    lost_ = true;
    try {
      arm_.stop();
    } catch (const std::exception& problem) {
      problem_ = std::string("the arm did not confirm a stop: ") + problem.what();
    }
  }

  bool is_over() {
    const std::lock_guard lock(mutex_);
    return over_;
  }

  /// True when the motion is over.
  bool pause() {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::duration<double>(kHoldPeriod), [this] { return over_; });
  }

  Arm& arm_;
  Gripper& gripper_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool over_ = false;
  bool lost_ = false;  // like `problem_` by the thread, read once it has ended
  std::string problem_;
  std::thread thread_;
};

}  // namespace

MotionResult HoldWatch::carry(const JointTrajectory& trajectory) {
  using Status = MotionResult::Status;
  Watching watching(*arm_, *gripper_);
  MotionResult result = arm_->follow(trajectory);
  const bool lost = watching.end();
  if (!lost || (result.status != Status::kDone && result.status != Status::kStopped)) return result;
  const std::string& problem = watching.problem();
  if (!problem.empty()) return {Status::kStopped, result.q, 0.0, concat(kDroppedReason, "; ", problem)};
  const ArmState state = arm_->state();
  if (state.can_move) return {Status::kDropped, state.q, 0.0, kDroppedReason};
  return result;
}

}  // namespace stonestack::hardware
