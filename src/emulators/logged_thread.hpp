#pragma once
#include <exception>
#include <string>
#include <thread>
#include <utility>

#include "stonestack/core/log.hpp"

namespace stonestack::emulators {

/// A thread whose work ends with a line in the log, and not with the process, where it throws. `name` is the
/// device's.
template <class Work>
[[nodiscard]] std::thread make_logged_thread(std::string name, Work work) {
  return std::thread([name = std::move(name), work = std::move(work)] {
    try {
      work();
    } catch (const std::exception& problem) {
      log_error(name + " has ended: " + problem.what());
    }
  });
}

}  // namespace stonestack::emulators
