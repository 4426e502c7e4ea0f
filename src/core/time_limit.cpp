#include "stonestack/core/clock.hpp"

#include <atomic>
#include <limits>

#include "stonestack/core/error.hpp"

namespace stonestack::core {
namespace {
std::atomic<const TimeLimit*> living{nullptr};
}

TimeLimit::TimeLimit(double seconds, const Clock& clock)
    : clock_(&clock), end_(seconds > 0.0 ? clock.now() + seconds : std::numeric_limits<double>::infinity()) {
  const TimeLimit* none = nullptr;
  require(living.compare_exchange_strong(none, this), "a time limit is set already");
}

TimeLimit::~TimeLimit() {
  living = nullptr;
}

bool TimeLimit::is_over() const {
  return end_ < std::numeric_limits<double>::infinity() && clock_->now() >= end_;
}

bool time_is_over() noexcept {
  const TimeLimit* limit = living;
  return limit != nullptr && limit->is_over();
}

}  // namespace stonestack::core
