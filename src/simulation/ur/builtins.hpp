#pragma once
#include "simulation/ur/controller.hpp"

namespace stonestack::simulation::urscript {

void add_math(std::vector<Builtin>& list);
void add_text(std::vector<Builtin>& list);
void add_poses(std::vector<Builtin>& list);
void add_state(std::vector<Builtin>& list);
void add_motion(std::vector<Builtin>& list);
void add_io(std::vector<Builtin>& list);
void add_flow(std::vector<Builtin>& list);
void add_sockets(std::vector<Builtin>& list);

/// Takes over what has come in, without waiting.
void receive(ScriptSocket& socket);

/// Shorthands for the tables.
inline const Value& arg(const BuiltinCall& call, std::size_t i) {
  return call.arguments[i];
}
inline double num(const BuiltinCall& call, std::size_t i) {
  return number(call.arguments[i]);
}
/// The number, which no NaN and no infinity may be.
double finite(const Value& value);
double finite_or(const BuiltinCall& call, std::size_t i, double preset);
/// The number within a range, both ends included; else a ScriptError that names the argument.
double within(double value, double least, double most, const char* what);

}  // namespace stonestack::simulation::urscript
