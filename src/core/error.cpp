#include "stonestack/core/error.hpp"

#include <atomic>

#include "stonestack/core/clock.hpp"

namespace stonestack::core {
namespace {
std::atomic<bool> interrupt_flag{false};  // set by signal handlers, and by threads
static_assert(std::atomic<bool>::is_always_lock_free);
}  // namespace

void note_interrupt() noexcept {
  interrupt_flag = true;
}

bool interrupt_noted() noexcept {
  return interrupt_flag || time_is_over();
}

void throw_if_interrupted() {
  if (interrupt_noted()) throw Interrupted();
}

}  // namespace stonestack::core
