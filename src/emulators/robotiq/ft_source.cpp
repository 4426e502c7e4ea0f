#include "emulators/robotiq/ft_source.hpp"

#include <chrono>
#include <utility>

#include "emulators/logged_thread.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::emulators {
namespace {

constexpr double kForceCount = 0.01;  // N

std::chrono::duration<double> seconds(double value) {
  return std::chrono::duration<double>(value);
}

}  // namespace

struct IdealWrenchPlant::State {
  std::mutex mutex;
  Wrench wrench;
  Random random{1};
};

IdealWrenchPlant::IdealWrenchPlant() : state_(std::make_unique<State>()) {}
IdealWrenchPlant::~IdealWrenchPlant() = default;

Wrench IdealWrenchPlant::sample(double /*seconds*/) {
  const std::lock_guard lock(state_->mutex);
  Wrench wrench = state_->wrench;
  for (auto& component : wrench.force) component += kForceCount * state_->random.uniform(-1.0, 1.0);
  return wrench;
}

void IdealWrenchPlant::set(const Wrench& wrench) {
  const std::lock_guard lock(state_->mutex);
  state_->wrench = wrench;
}

FtSource::FtSource(WrenchPlant& plant, double rate, double speed_up)
    : plant_(&plant),
      rate_(rate),
      speed_up_(speed_up),
      thread_(make_logged_thread("simulated force sensor", [this] { run(); })) {}

FtSource::~FtSource() {
  stop_ = true;
  thread_.join();
}

void FtSource::run() {
  using Steady = std::chrono::steady_clock;
  for (auto next = Steady::now(); !stop_;) {
    const double slow = faults().rate;
    const double period = 1.0 / (slow > 0 ? slow : rate_);
    next = std::max(next + std::chrono::duration_cast<Steady::duration>(seconds(period)), Steady::now());
    std::this_thread::sleep_until(next);
    const Wrench wrench = plant_->sample(period * speed_up_);
    const std::lock_guard lock(mutex_);
    drifted_ = faults_.drift != 0 ? drifted_ + faults_.drift * period : 0.0;
    FtReading reading{wrench.force.x(),  wrench.force.y(),  wrench.force.z(),
                      wrench.torque.x(), wrench.torque.y(), wrench.torque.z()};
    newest_ = {newest_.number + 1, spoil(reading)};
    sampled_.notify_all();
  }
}

FtReading FtSource::spoil(FtReading reading) {
  if (faults_.stuck) return newest_.reading;
  if (faults_.zeros) return {};
  if (faults_.saturated) return {327.67, -327.68, 327.67, 32.767, -32.768, 32.767};
  reading[2] += drifted_ + faults_.spike;
  faults_.spike = 0.0;
  return reading;
}

std::optional<FtSource::Sample> FtSource::newer_than(long number, double patience) {
  std::unique_lock lock(mutex_);
  if (!sampled_.wait_for(lock, seconds(patience), [&] { return newest_.number > number; }))
    return std::nullopt;
  return newest_;
}

FtReading FtSource::newest() {
  const std::lock_guard lock(mutex_);
  return newest_.reading;
}

void FtSource::set_faults(const FtFaults& faults) {
  const std::lock_guard lock(mutex_);
  faults_ = faults;
}

FtFaults FtSource::faults() {
  const std::lock_guard lock(mutex_);
  return faults_;
}

bool FtSource::take(int FtFaults::*fault) {
  const std::lock_guard lock(mutex_);
  int& left = faults_.*fault;
  if (left == 0) return false;
  if (left > 0) --left;
  return true;
}

bool FtSource::take_power_cycle() {
  const std::lock_guard lock(mutex_);
  return std::exchange(faults_.forgets, false);
}

}  // namespace stonestack::emulators
