// The URCap External Control as UR's client library sees it: a program on the pendant that asks the library's
// script sender for what to run.
#include "emulators/ur/builtins.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

constexpr const char* kSender = "external_control";
constexpr const char* kLastLine = "# NODE_CONTROL_LOOP_ENDS";

}  // namespace

// The controller makes its steps meanwhile: the wait is a program, too.
void UrController::ask_for_program() {
  const std::string where = concat("127.0.0.1:", options_.external_control);
  run_script(
      concat("def external_control():\n  if not socket_open(\"127.0.0.1\", ", options_.external_control,
             ", \"", kSender, "\"):\n    textmsg(\"External Control: nobody listens at ", where,
             "\")\n    halt\n  end\n  socket_send_line(\"request_program\", \"", kSender,
             "\")\n  sleep(5)\n  textmsg(\"External Control: no program came from ", where, "\")\nend\n"));
  asked_ = program_running();
  if (asked_) program_name_ = loaded_program;
}

void UrController::take_program_asked_for() {
  const auto sender = sockets.find(kSender);
  if (sender == sockets.end()) return;
  receive(sender->second);
  const std::string& text = sender->second.received;
  if (text.find(kLastLine) == std::string::npos) return;
  run_script("def external_control():\n" + text + "\nend\n");
  if (asked_) stop_program();  // it does not compile: the messages give the reason
  if (program_running()) program_name_ = loaded_program;
}

}  // namespace stonestack::emulators
