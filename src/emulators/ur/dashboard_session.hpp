#pragma once
#include "emulators/ur/controller.hpp"

namespace stonestack::emulators {

/// Greeting of the Dashboard to every client.
inline constexpr const char* kDashboardGreeting = "Connected: Universal Robots Dashboard Server";

/// One line of the Dashboard protocol, without its end.
struct DashboardAnswer {
  std::string line;
  bool closes = false;  ///< `quit`
};
[[nodiscard]] DashboardAnswer answer_dashboard(UrController& controller, const std::string& command);

}  // namespace stonestack::emulators
