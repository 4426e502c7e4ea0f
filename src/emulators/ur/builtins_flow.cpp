#include <cmath>

#include "emulators/ur/builtins.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/protocol/rtde_fields.hpp"

namespace stonestack::emulators {
namespace {

Outcome sleep_for(BuiltinCall& call) {
  const double seconds = num(call, 0);
  if (!(seconds >= 0) || !std::isfinite(seconds)) throw ScriptError{"Value error: sleep needs a time"};
  const double until = controller(call).uptime() + seconds;
  return Wait([&host = controller(call), until]() -> std::optional<Value> {
    if (host.uptime() < until - 1e-9) return std::nullopt;
    return Value();
  });
}

Outcome message(BuiltinCall& call) {
  ControllerEvent event;
  event.kind = ControllerEvent::Kind::kText;
  event.text = print(arg(call, 0)) + (call.has(1) ? print(arg(call, 1)) : "");
  controller(call).emit(std::move(event));
  return Value();
}

Outcome popup(BuiltinCall& call) {
  ControllerEvent event;
  event.kind = ControllerEvent::Kind::kPopup;
  event.text = print(arg(call, 0));
  event.title = call.has(1) ? print(arg(call, 1)) : "Popup";
  event.warning = call.has(2) && truth(arg(call, 2));
  event.error = call.has(3) && truth(arg(call, 3));
  event.blocking = call.has(4) && truth(arg(call, 4));
  const bool blocking = event.blocking;
  controller(call).emit(std::move(event));
  if (!blocking) return Value();
  controller(call).popup_open = true;
  return Wait([&host = controller(call)]() -> std::optional<Value> {
    if (host.popup_open) return std::nullopt;
    return Value();
  });
}

Outcome set_watchdog(BuiltinCall& call) {
  Watchdog watchdog;
  watchdog.variable = text(arg(call, 0));
  const double frequency = num(call, 1);
  watchdog.action = call.has(2) ? text(arg(call, 2)) : "pause";
  if (!find_rtde_input(watchdog.variable))
    throw ScriptError{"Value error: there is no RTDE input " + watchdog.variable.substr(0, 60)};
  if (!(frequency > 0) || frequency > 500) throw ScriptError{"Value error: a watchdog needs a frequency"};
  if (watchdog.action != "stop" && watchdog.action != "pause" && watchdog.action != "ignore")
    throw ScriptError{"Value error: a watchdog's action is ignore, pause or stop"};
  watchdog.period = 1.0 / frequency;
  watchdog.fed = controller(call).uptime();
  controller(call).watchdog = watchdog;
  return Value();
}

}  // namespace

void add_flow(std::vector<Builtin>& list) {
  list.push_back({"sleep", {"t"}, 1, sleep_for});
  list.push_back({"textmsg", {"s1", "s2"}, 1, message});
  list.push_back({"popup", {"s", "title", "warning", "error", "blocking"}, 1, popup});
  list.push_back({"rtde_set_watchdog", {"variable_name", "min_frequency", "action"}, 2, set_watchdog});
  // Seconds since the controller was switched on; UR's client library notes with it when a command came.
  list.push_back(
      {"time", {"mode"}, 0, [](BuiltinCall& c) { return Outcome(Value(controller(c).timestamp())); }});
}

}  // namespace stonestack::emulators
