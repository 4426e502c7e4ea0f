#pragma once
#include <sstream>
#include <stdexcept>
#include <string>

#include "stonestack/core/rooms.hpp"

#pragma GCC visibility push(default)

/// Errors are split by who must act. Expected outcomes (nothing seen, no stable pose, no inverse
/// kinematics) are values, not errors.
namespace stonestack::core {

/// Exit codes of the command; the same everywhere (README, "Exit codes").
enum class ExitCode {
  kDone = 0,
  kInternal = 1,
  kUsage = 2,
  kUnreadable = 3,
  kNothingDetected = 4,
  kNoStablePose = 5,
  kExecutionFailed = 6,
  kSafetyStop = 7,
  kInterrupted = 130,
};

/// Base of every error of this library; `exit_code()` is what the command ends with.
class Error : public std::runtime_error {
 public:
  /// Error with its message, and the exit code that the command ends with.
  Error(const std::string& what, ExitCode code) : std::runtime_error(what), exit_code_(code) {}
  /// Exit code that the command ends with.
  [[nodiscard]] ExitCode exit_code() const { return exit_code_; }

 private:
  ExitCode exit_code_;
};

/// The caller broke the contract; the message carries the values.
class InvalidArgument : public Error {
 public:
  /// Error with its message, which carries the values.
  explicit InvalidArgument(const std::string& what) : Error(what, ExitCode::kUsage) {}
};

/// A file is missing or does not hold what it should. `what()` reads
/// "<path>: <what is wrong, with the value>; <what to do>".
class FileError : public Error {
 public:
  /// Joins the file's path, what is wrong with it, and the remedy.
  FileError(const std::string& path, const std::string& problem, const std::string& remedy)
      : Error(path + ": " + problem + "; " + remedy, ExitCode::kUnreadable) {}
};

/// A device does not answer or refuses. `what()` reads "<device at address>: <problem>; <next step>".
class DeviceError : public Error {
 public:
  /// Joins the device and its address, the problem, and the next step.
  DeviceError(const std::string& device, const std::string& problem, const std::string& next_step)
      : Error(device + ": " + problem + "; " + next_step, ExitCode::kExecutionFailed) {}
};

/// The user pressed Ctrl-C or the process received a signal to end.
class Interrupted : public Error {
 public:
  Interrupted() : Error("interrupted", ExitCode::kInterrupted) {}
};

/// Joins its arguments as a stream would.
template <class... Parts>
[[nodiscard]] std::string concat(const Parts&... parts) {
  std::ostringstream out;
  (out << ... << parts);
  return out.str();
}

/// Throws InvalidArgument with the joined parts unless `condition` holds:
/// `require(radius > 0, "radius must be positive, got ", radius, " m")`.
template <class... Parts>
void require(bool condition, const Parts&... parts) {
  if (!condition) throw InvalidArgument(concat(parts...));
}

/// Throws Interrupted after `note_interrupt`, or once a `TimeLimit` is over. Long loops call it once a turn.
void throw_if_interrupted();
/// Async-signal-safe: remembers that the process was asked to end.
void note_interrupt() noexcept;
/// True once `note_interrupt` was called, and while the time of a `TimeLimit` is over.
[[nodiscard]] bool interrupt_noted() noexcept;

}  // namespace stonestack::core

#pragma GCC visibility pop
