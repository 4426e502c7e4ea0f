#include "stonestack/core/clock.hpp"

#include <atomic>
#include <chrono>
#include <ctime>
#include <limits>

#include "stonestack/core/error.hpp"

namespace stonestack::core {
namespace {

std::atomic<const TimeLimit*> time_limit{nullptr};

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

class SteadyClock : public Clock {
 public:
  [[nodiscard]] double now() const override { return steady_seconds() - start_; }

 private:
  double start_ = steady_seconds();
};

}  // namespace

std::unique_ptr<Clock> make_steady_clock() {
  return std::make_unique<SteadyClock>();
}

double host_seconds() {
  return steady_seconds();
}

double processor_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

TimeLimit::TimeLimit(double seconds, const Clock& clock)
    : clock_(&clock), end_(seconds > 0.0 ? clock.now() + seconds : std::numeric_limits<double>::infinity()) {
  const TimeLimit* none = nullptr;
  require(time_limit.compare_exchange_strong(none, this), "a time limit is set already");
}

TimeLimit::~TimeLimit() {
  time_limit = nullptr;
}

bool TimeLimit::is_over() const {
  return end_ < std::numeric_limits<double>::infinity() && clock_->now() >= end_;
}

bool time_is_over() noexcept {
  const TimeLimit* limit = time_limit;
  return limit != nullptr && limit->is_over();
}

Stopwatch::Stopwatch() : start_(steady_seconds()) {}

double Stopwatch::seconds() const {
  return steady_seconds() - start_;
}

}  // namespace stonestack::core
