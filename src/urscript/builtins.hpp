#pragma once
#include "urscript/machine.hpp"

namespace stonestack::urscript {

/// The functions of the language itself, which need no controller: numbers, lists, text, poses, `sync`,
/// `assert`, `struct`.
[[nodiscard]] std::vector<Builtin> language_functions();

void add_math(std::vector<Builtin>& list);
void add_text(std::vector<Builtin>& list);
void add_poses(std::vector<Builtin>& list);

/// Shorthands for the tables.
inline const Value& arg(const BuiltinCall& call, std::size_t i) {
  return call.arguments[i];
}
inline double num(const BuiltinCall& call, std::size_t i) {
  return number(call.arguments[i]);
}
inline Pose pose(const BuiltinCall& call, std::size_t i) {
  return to_pose(six(arg(call, i)));
}
/// The number, which no NaN and no infinity may be.
double finite(const Value& value);
double finite_or(const BuiltinCall& call, std::size_t i, double preset);
/// The number within a range, both ends included; else a ScriptError that names the argument.
double within(double value, double min, double max, const char* what);

}  // namespace stonestack::urscript
