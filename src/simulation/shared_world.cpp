#include "simulation/shared_world.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::simulation {
namespace {

constexpr double kTick = 0.002;  // s, period of the fingers' force control

}  // namespace

SharedWorld::SharedWorld(TrueWorld& world, const TrueMounting& mounting, const RobotModel& robot,
                         const std::vector<Stone>& stones, const SimulationOptions& options)
    : world_(&world), mounting_(mounting), robot_(robot), stones_(&stones), options_(options) {}

SharedWorld::~SharedWorld() {
  stop();
}

SharedWorld::Access SharedWorld::lock() {
  return {std::unique_lock(mutex_), *world_};
}

Progress SharedWorld::advance(const Pose& T_W_T, double seconds) {
  const Pose start = world_->commanded_pose().T_W_T;
  const bool moves = !start.isApprox(T_W_T, 0.0);
  Progress total;
  const int ticks = std::max(1, static_cast<int>(std::ceil(seconds / kTick - 1e-9)));
  for (int k = 0; k < ticks && total.stopped.empty(); ++k) {
    const double tick = seconds / ticks;
    const GripperPose from = world_->commanded_pose();
    const FingerPlaces to = drive_ ? drive_(*world_, tick) : FingerPlaces{from.finger, from.narrowed};
    const auto path = [&](double s) {
      GripperPose gripper_pose = from;
      const double share = std::clamp(s / tick, 0.0, 1.0);
      if (moves) gripper_pose.T_W_T = interpolate(start, T_W_T, (k + share) / ticks);
      for (std::size_t f = 0; f < to.finger.size(); ++f)
        gripper_pose.finger[f] += share * (to.finger[f] - from.finger[f]);
      gripper_pose.narrowed += share * (to.narrowed - from.narrowed);
      return gripper_pose;
    };
    const Progress progress = world_->advance(tick, path);
    total.seconds += progress.seconds;
    total.stopped = progress.stopped;
  }
  return total;
}

Progress SharedWorld::move_arm(const Pose& T_W_T, double seconds) {
  Progress progress;
  {
    const std::lock_guard guard(mutex_);
    progress = advance(T_W_T, seconds);
  }
  time_passed_.notify_all();
  return progress;
}

Progress SharedWorld::pass(double seconds) {
  Progress progress;
  {
    const std::lock_guard guard(mutex_);
    progress = advance(world_->commanded_pose().T_W_T, seconds);
  }
  time_passed_.notify_all();
  return progress;
}

void SharedWorld::drive_fingers(FingerDrive drive) {
  const std::lock_guard guard(mutex_);
  drive_ = std::move(drive);
}

double SharedWorld::time() const {
  const std::lock_guard guard(mutex_);
  return world_->time();
}

bool SharedWorld::wait_until(double time, double host_seconds) {
  std::unique_lock guard(mutex_);
  return time_passed_.wait_for(guard, std::chrono::duration<double>(host_seconds),
                               [&] { return world_->time() >= time - 1e-9; });
}

void SharedWorld::start(double speed) {
  require(speed > 0 && std::isfinite(speed), "time passes at a positive speed, got ", speed);
  stop();
  stopping_ = false;
  loop_ = std::thread([this, speed] {
    try {
      pass_time(speed);
    } catch (const std::exception& problem) {
      log_error(std::string("simulated world: time stands still: ") + problem.what());
    }
  });
}

void SharedWorld::pass_time(double speed) {
  using Steady = std::chrono::steady_clock;
  const auto period =
      std::chrono::duration_cast<Steady::duration>(std::chrono::duration<double>(kTick / speed));
  std::unique_lock guard(mutex_);
  for (auto next = Steady::now(); !stopping_;) {
    advance(world_->commanded_pose().T_W_T, kTick);
    time_passed_.notify_all();
    next = std::max(next + period, Steady::now() - 50 * period);  // never races to catch up for long
    guard.unlock();
    std::this_thread::sleep_until(next);
    guard.lock();
  }
}

void SharedWorld::stop() {
  {
    const std::lock_guard guard(mutex_);
    stopping_ = true;
  }
  if (loop_.joinable()) loop_.join();
}

}  // namespace stonestack::simulation
