#pragma once
#include <pybind11/pybind11.h>
#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <optional>

#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

/// Private to the Python module: long calls into the library, and errors as Python's exceptions.
namespace stonestack::python {

/// Steady time; infinitely late once Ctrl-C was pressed during a call. A `TimeLimit` by this clock ends long
/// work on Ctrl-C and leaves the process fit for the next call.
class CallClock : public core::Clock {
 public:
  [[nodiscard]] double now() const override;
};

/// One long call. On the main thread Ctrl-C ends it, unless Python ignores SIGINT.
class LongCall {
 public:
  /// `seconds` after which the call ends with what it has; 0: no limit.
  explicit LongCall(double seconds);
  ~LongCall();
  LongCall(const LongCall&) = delete;
  LongCall& operator=(const LongCall&) = delete;
  /// Hands a Ctrl-C of this call to Python: throws what Python's handler raises, KeyboardInterrupt as a rule.
  void pass_on_interrupt();

 private:
  CallClock clock_;
  std::optional<core::TimeLimit> limit_;
  struct sigaction before_ {};
  bool installed_ = false;
};

/// Result of `work`, which runs without Python's lock and touches no Python object.
template <class Work>
auto call(const Work& work, double seconds = 0.0) {
  LongCall guard(seconds);
  try {
    auto result = [&] {
      const pybind11::gil_scoped_release unlocked;
      return work();
    }();
    guard.pass_on_interrupt();
    return result;
  } catch (const core::Interrupted&) {
    guard.pass_on_interrupt();
    throw;
  }
}

/// Adds Error and its subclasses to the module, and translates the library's errors into them.
void add_errors(pybind11::module_& module);

}  // namespace stonestack::python
