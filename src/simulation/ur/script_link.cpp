#include <algorithm>
#include <cstdlib>

#include "simulation/ur/primary_messages.hpp"
#include "simulation/ur/server_links.hpp"

namespace stonestack {
namespace {

constexpr double kStateRate = 10.0;  // Hz of primary and secondary
constexpr double kPatience = 1.0;    // s for the rest of a program: then it is a syntax error

std::string trimmed(const std::string& line) {
  const auto first = line.find_first_not_of(" \t\r"), last = line.find_last_not_of(" \t\r");
  return first == std::string::npos ? "" : line.substr(first, last - first + 1);
}

}  // namespace

ScriptLink::ScriptLink(TcpStream stream, UrController& controller, Kind kind, bool read_only)
    : ServerLink(std::move(stream), controller, Unread::kSkipped),  // many clients only ever write here
      kind_(kind),
      read_only_(read_only),
      next_state_(controller.steps()) {
  if (kind != Kind::kRealtime) send(encode_version_message(controller));
}

void ScriptLink::tell(const ControllerEvent& event) {
  if (kind_ == Kind::kPrimary) send(encode_event(controller(), event));
}

void ScriptLink::receive(std::string_view bytes) {
  heard_ = controller().uptime();
  for (const auto& script : collector_.feed(bytes)) take(script);
}

void ScriptLink::take(const std::string& script) {
  const bool local = controller().faults.local_mode && !controller().version().is_cb3();
  if (read_only_ || local) return tell(read_only_error());
  if (!take_command(trimmed(script))) controller().run_script(script);
}

// What a script port understands besides URScript.
bool ScriptLink::take_command(const std::string& line) {
  UrController& c = controller();
  if (line == "power on") {
    c.power_on();
  } else if (line == "power off") {
    c.power_off();
  } else if (line == "set robotmode run") {
    c.release_brakes();
  } else if (line == "set unlock protective stop") {
    static_cast<void>(c.unlock_protective_stop());
  } else if (line == "stop program") {
    c.stop_program();
  } else if (line.rfind("set speed ", 0) == 0) {
    const double speed = std::strtod(line.c_str() + 10, nullptr);
    if (speed >= 0 && speed <= 1) c.speed_slider = speed;
  } else {
    // ur_rtde ends its upload with this line; with nothing loaded there is nothing to run.
    return line == "run program";
  }
  return true;
}

void ScriptLink::after_step() {
  UrController& c = controller();
  if (collector_.inside_program() && c.uptime() - heard_ > kPatience) take(collector_.give_up());
  if (kind_ == Kind::kRealtime) return offer(encode_realtime(c));
  if (c.steps() < next_state_) return;
  next_state_ = c.steps() + static_cast<std::uint64_t>(1.0 / (kStateRate * c.period()) + 0.5);
  offer(encode_robot_state(c));
}

}  // namespace stonestack
