#pragma once
#include <string>

#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/hardware/cell.hpp"

/// Private to stacking/: what measurements that move the arm share.
namespace stonestack::stacking {

/// The arm has ended a motion otherwise than asked.
/// @throws Error (safety stop) where it cannot move, DeviceError otherwise
[[noreturn]] void report_stop(Cell& cell, const std::string& reason);

/// Result of `work`. Whatever it throws, the arm is stopped first.
template <class Work>
auto stopping_on_failure(Cell& cell, const Work& work) {
  try {
    return work();
  } catch (...) {
    try {
      cell.arm.stop();
    } catch (const Error& problem) {  // what ended the work is reported by the caller
      log_warning(problem.what());
    }
    throw;
  }
}

}  // namespace stonestack::stacking
