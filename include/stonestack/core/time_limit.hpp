#pragma once
#include "stonestack/core/clock.hpp"

#pragma GCC visibility push(default)

namespace stonestack::core {

/// Ends long work at a time: while one lives and its time is over, `interrupt_noted` answers true and
/// `throw_if_interrupted` throws, as after Ctrl-C, so that whatever can be interrupted keeps to the limit and
/// overruns it by no more than one turn of its loops. `time_is_over` tells the two apart. At most one lives
/// in a process at a time (InvalidArgument else); a program sets it, a library never does.
class TimeLimit {
 public:
  /// `seconds` from now by `clock`, which must outlive it and be callable from any thread; 0: no limit.
  TimeLimit(double seconds, const Clock& clock);
  ~TimeLimit();
  TimeLimit(const TimeLimit&) = delete;
  TimeLimit& operator=(const TimeLimit&) = delete;
  [[nodiscard]] bool is_over() const;

 private:
  const Clock* clock_;
  double end_;
};
/// Whether a TimeLimit lives whose time is over.
[[nodiscard]] bool time_is_over() noexcept;

}  // namespace stonestack::core

#pragma GCC visibility pop
