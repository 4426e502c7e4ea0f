#include "stonestack/core/error.hpp"

#include <csignal>

#include "stonestack/core/clock.hpp"

namespace stonestack::core {
namespace {
volatile std::sig_atomic_t interrupt_flag = 0;
}

void note_interrupt() noexcept {
  interrupt_flag = 1;
}

bool interrupt_noted() noexcept {
  return interrupt_flag != 0 || time_is_over();
}

void throw_if_interrupted() {
  if (interrupt_noted()) throw Interrupted();
}

}  // namespace stonestack::core
