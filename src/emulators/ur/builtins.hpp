#pragma once
#include "emulators/ur/controller.hpp"
#include "urscript/builtins.hpp"

namespace stonestack::emulators {

void add_kinematics(std::vector<Builtin>& list);
void add_state(std::vector<Builtin>& list);
void add_motion(std::vector<Builtin>& list);
void add_io(std::vector<Builtin>& list);
void add_flow(std::vector<Builtin>& list);
void add_sockets(std::vector<Builtin>& list);

/// Takes over what has come in, without waiting.
void receive(ScriptSocket& socket);

/// The controller that runs the program which calls. Programs run on a UrController only: it makes the
/// machines.
inline UrController& controller(const BuiltinCall& call) {
  return static_cast<UrController&>(call.host);
}

}  // namespace stonestack::emulators
