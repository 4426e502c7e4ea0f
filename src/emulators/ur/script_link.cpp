#include <utility>

#include "emulators/ur/primary_messages.hpp"
#include "emulators/ur/server_links.hpp"

namespace stonestack::emulators {
namespace {

constexpr double kStateRate = 10.0;      // Hz of primary and secondary
constexpr int kReadsAStep = 16;          // a script of 4,000,000 characters has come in some 30 steps
constexpr double kScriptPatience = 1.0;  // s for the rest of a program: then it is a syntax error

}  // namespace

ScriptLink::ScriptLink(TcpStream stream, UrController& controller, ScriptQueue& queue, int number, Kind kind,
                       bool read_only)
    : ServerLink(std::move(stream), controller, Unread::kSkipped,  // many clients only ever write here
                 kReadsAStep),
      queue_(&queue),
      number_(number),
      kind_(kind),
      read_only_(read_only),
      next_state_(controller.steps()) {
  if (kind != Kind::kRealtime) send(encode_version_message(controller));
}

void ScriptLink::report(const ControllerEvent& event) {
  if (kind_ == Kind::kPrimary) send(encode_event(controller(), event));
}

void ScriptLink::receive(std::string_view bytes) {
  heard_ = controller().uptime();
  for (const auto& script : collector_.feed(bytes)) take(script);
}

void ScriptLink::take(const std::string& script) {
  const bool local = controller().faults.local_mode && !controller().version().is_cb3();
  if (read_only_ || local) return report(read_only_error());
  queue_->put(number_, script);
}

void ScriptLink::after_step() {
  UrController& c = controller();
  if (collector_.inside_program() && c.uptime() - heard_ > kScriptPatience) take(collector_.give_up());
  if (kind_ == Kind::kRealtime) return offer(encode_realtime(c));
  if (!state_required_ && c.steps() < next_state_) return;
  next_state_ = c.steps() + static_cast<std::uint64_t>(1.0 / (kStateRate * c.period()) + 0.5);
  if (std::exchange(state_required_, false))
    send(encode_robot_state(c));
  else
    offer(encode_robot_state(c));
}

}  // namespace stonestack::emulators
