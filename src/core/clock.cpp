#include "stonestack/core/clock.hpp"

#include <chrono>
#include <ctime>

namespace stonestack::core {
namespace {

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

Stopwatch::Stopwatch() : start_(steady_seconds()) {}

double Stopwatch::seconds() const {
  return steady_seconds() - start_;
}

}  // namespace stonestack::core
