#pragma once
#include <memory>

#include "stonestack/core/rooms.hpp"

#pragma GCC visibility push(default)

namespace stonestack::core {

/// Where time comes from: the steady clock of the host, or a simulation's. Seconds since the
/// clock was made; never wall time, which may jump.
class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual double now() const = 0;
};

/// std::chrono::steady_clock.
[[nodiscard]] std::unique_ptr<Clock> make_steady_clock();

/// s of std::chrono::steady_clock, one origin for all of the process: when something reached this host.
[[nodiscard]] double host_seconds();

/// of all threads of this process so far [s]: what a stage costs, however busy the machine is.
[[nodiscard]] double processor_seconds();

/// Measures how long a stage took: `Stopwatch watch; ...; watch.seconds()`. Host time.
class Stopwatch {
 public:
  Stopwatch();
  [[nodiscard]] double seconds() const;

 private:
  double start_;
};

}  // namespace stonestack::core

#pragma GCC visibility pop
