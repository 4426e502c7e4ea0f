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
  /// Time [s] since a start that each clock chooses; it never goes back.
  [[nodiscard]] virtual double now() const = 0;
};

/// std::chrono::steady_clock.
[[nodiscard]] std::unique_ptr<Clock> make_steady_clock();

/// Time [s] of std::chrono::steady_clock, one origin for all of the process: when something reached this
/// host.
[[nodiscard]] double host_seconds();

/// CPU time of all threads of this process so far [s]: what a stage costs, however busy the machine is.
[[nodiscard]] double processor_seconds();

/// Measures how long a stage took: `Stopwatch watch; ...; watch.seconds()`. Host time.
class Stopwatch {
 public:
  Stopwatch();
  /// Time [s] since the stopwatch was made.
  [[nodiscard]] double seconds() const;

 private:
  double start_;
};

/// Ends long work at a time: while one lives and its time is over, `interrupt_noted` answers true and
/// `throw_if_interrupted` throws, as after Ctrl-C, so that whatever can be interrupted keeps to the limit and
/// overruns it by no more than one turn of its loops. `time_is_over` distinguishes the two. At most one lives
/// in a process at a time (InvalidArgument else); a program sets it, a library never does.
class TimeLimit {
 public:
  /// `seconds` from now by `clock`, which must outlive it and be callable from any thread; 0: no limit.
  TimeLimit(double seconds, const Clock& clock);
  ~TimeLimit();
  TimeLimit(const TimeLimit&) = delete;
  TimeLimit& operator=(const TimeLimit&) = delete;
  /// True once the time of the limit is over.
  [[nodiscard]] bool is_over() const;

 private:
  const Clock* clock_;
  double end_;
};
/// Whether a TimeLimit lives whose time is over.
[[nodiscard]] bool time_is_over() noexcept;

}  // namespace stonestack::core

#pragma GCC visibility pop
