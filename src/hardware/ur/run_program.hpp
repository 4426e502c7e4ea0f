#pragma once
#include <functional>

#include "hardware/ur/ur_link.hpp"

/// Sends one program and waits for its end: run id, program not running, and an end state, all three.
namespace stonestack::hardware {

struct ProgramOrder {
  std::string script;
  int run = 0;
  double duration = 0.0;                           ///< time [s] that it takes at full speed
  std::function<void(const UrStatus&)> each_turn;  ///< called on every status, e.g. to stream a force
  const std::atomic<bool>* stop_asked = nullptr;
};

/// kDone, kContact and kNoContact are the program's own ends; otherwise `reason` gives the cause, and a stop
/// was sent, unless `stop_asked` kept the program itself from being sent. A pause by a person is waited for,
/// up to `pause_limit`. Whatever the end, the program does not run any more, or the link is without a
/// heartbeat and the controller's watchdog ends it. Rethrows what `each_turn` throws and Interrupted, after
/// stopping.
[[nodiscard]] MotionResult run_program(UrLink& link, const ProgramOrder& order);
/// Sends a stop program and returns its run id; 0, and the link is without a heartbeat, where that failed.
/// Never throws.
int send_stop(UrLink& link) noexcept;

}  // namespace stonestack::hardware
