#pragma once
#include "simulation/ur/controller.hpp"

namespace stonestack::urscript {

void add_math(std::vector<Builtin>& list);
void add_text(std::vector<Builtin>& list);
void add_poses(std::vector<Builtin>& list);
void add_state(std::vector<Builtin>& list);
void add_motion(std::vector<Builtin>& list);
void add_io(std::vector<Builtin>& list);
void add_flow(std::vector<Builtin>& list);
void add_sockets(std::vector<Builtin>& list);

/// Shorthands for the tables.
inline const Value& arg(const BuiltinCall& call, std::size_t i) {
  return call.arguments[i];
}
inline double num(const BuiltinCall& call, std::size_t i) {
  return number(call.arguments[i]);
}

}  // namespace stonestack::urscript
