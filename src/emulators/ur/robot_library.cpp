// The functions that a UR controller offers to its programs.
#include <string_view>

#include "emulators/ur/builtins.hpp"

namespace stonestack::emulators {
namespace {

// What takes the host longer than an instruction does: inverse kinematics, connections, bytes on the wire.
constexpr std::pair<std::string_view, int> kEfforts[] = {
    {"get_inverse_kin", 100},
    {"get_inverse_kin_has_solution", 100},
    {"is_within_safety_limits", 100},
    {"get_forward_kin", 10},
    {"tool_contact", 100},
    {"textmsg", 50},
    {"popup", 50},
    {"socket_open", urscript::kStepQuota},
    {"socket_close", 100},
    {"socket_read_binary_integer", 100},
    {"socket_read_ascii_float", 100},
    {"socket_read_byte_list", 100},
    {"socket_set_var", 100},
    {"socket_get_var", 100},
    {"socket_read_line", 100},
    {"socket_read_string", 100},
    {"socket_send_int", 100},
    {"socket_send_byte", 100},
    {"socket_send_string", 100},
    {"socket_send_line", 100},
};

std::vector<Builtin> robot_functions() {
  std::vector<Builtin> list = urscript::language_functions();
  add_kinematics(list);
  add_state(list);
  add_motion(list);
  add_io(list);
  add_flow(list);
  add_sockets(list);
  for (auto& builtin : list)
    for (const auto& [name, effort] : kEfforts)
      if (name == builtin.name) builtin.effort = effort;
  return list;
}

}  // namespace

const urscript::Library& robot_library() {
  static const urscript::Library library(robot_functions());
  return library;
}

}  // namespace stonestack::emulators
