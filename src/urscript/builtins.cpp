#include "urscript/builtins.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "stonestack/core/error.hpp"

namespace stonestack::urscript {
namespace {

template <double (*kFunction)(double)>
Outcome one_number(BuiltinCall& call) {
  const double result = kFunction(num(call, 0));
  if (!std::isfinite(result)) throw ScriptError{"Value error: argument out of range"};
  return Value(result);
}

Outcome norm_of(BuiltinCall& call) {
  const Value& a = arg(call, 0);
  if (is_pose(a)) return Value(six(a).norm());
  const auto* list = std::get_if<List>(&a.is);
  if (!list) return Value(std::abs(number(a)));
  double sum = 0;
  for (const auto& item : *list) sum += number(item) * number(item);
  return Value(std::sqrt(sum));
}

Outcome power(BuiltinCall& call) {
  const double result = std::pow(num(call, 0), num(call, 1));
  if (!std::isfinite(result)) throw ScriptError{"Value error: argument out of range"};
  return Value(result);
}

Outcome to_whole(BuiltinCall& call, double (*round)(double)) {
  const double value = round(num(call, 0));
  if (!(std::abs(value) <= 2147483647.0)) throw ScriptError{"Value error: integer out of range"};
  return Value(static_cast<long long>(value));
}

Outcome bits_of(BuiltinCall& call) {
  const auto bits = static_cast<std::uint32_t>(integer(arg(call, 0)));
  List list;
  for (int i = 0; i < 32; ++i) list.emplace_back((bits >> i & 1U) != 0);
  return Value(list);
}

Outcome number_of_bits(BuiltinCall& call) {
  const auto* list = std::get_if<List>(&arg(call, 0).is);
  if (!list || list->size() > 32) throw ScriptError{"Type error: expected a list of up to 32 Booleans"};
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < list->size(); ++i) bits |= (truth((*list)[i]) ? 1U : 0U) << i;
  return Value(static_cast<long long>(static_cast<std::int32_t>(bits)));
}

Outcome list_length(BuiltinCall& call) {
  if (const auto* string = std::get_if<std::string>(&arg(call, 0).is))
    return Value(static_cast<long long>(string->size()));
  if (is_pose(arg(call, 0))) return Value(6);
  const auto* list = std::get_if<List>(&arg(call, 0).is);
  if (!list) throw ScriptError{"Type error: expected a list"};
  return Value(static_cast<long long>(list->size()));
}

Outcome check(BuiltinCall& call) {
  if (!truth(arg(call, 0))) throw ScriptError{"Assertion failed"};
  return Value();
}

Outcome sync_step(BuiltinCall&) {
  return Wait([]() -> std::optional<Value> { return Value(); });
}

}  // namespace

void add_math(std::vector<Builtin>& list) {
  list.push_back({"sin", {"f"}, 1, one_number<std::sin>});
  list.push_back({"cos", {"f"}, 1, one_number<std::cos>});
  list.push_back({"tan", {"f"}, 1, one_number<std::tan>});
  list.push_back({"asin", {"f"}, 1, one_number<std::asin>});
  list.push_back({"acos", {"f"}, 1, one_number<std::acos>});
  list.push_back({"atan", {"f"}, 1, one_number<std::atan>});
  list.push_back({"sqrt", {"f"}, 1, one_number<std::sqrt>});
  list.push_back({"log", {"b", "f"}, 2, [](BuiltinCall& c) {
                    const double value = std::log(num(c, 1)) / std::log(num(c, 0));
                    if (!std::isfinite(value)) throw ScriptError{"Value error: argument out of range"};
                    return Outcome(Value(value));
                  }});
  list.push_back({"atan2", {"x", "y"}, 2, [](BuiltinCall& c) {
                    return Outcome(Value(std::atan2(num(c, 0), num(c, 1))));
                  }});
  list.push_back({"pow", {"base", "exponent"}, 2, power});
  list.push_back({"floor", {"f"}, 1, [](BuiltinCall& c) { return to_whole(c, std::floor); }});
  list.push_back({"ceil", {"f"}, 1, [](BuiltinCall& c) { return to_whole(c, std::ceil); }});
  list.push_back(
      {"d2r", {"d"}, 1, [](BuiltinCall& c) { return Outcome(Value(num(c, 0) * std::numbers::pi / 180.0)); }});
  list.push_back(
      {"r2d", {"r"}, 1, [](BuiltinCall& c) { return Outcome(Value(num(c, 0) * 180.0 / std::numbers::pi)); }});
  list.push_back({"norm", {"a"}, 1, norm_of});
  list.push_back({"integer_to_binary_list", {"x"}, 1, bits_of});
  list.push_back({"binary_list_to_integer", {"l"}, 1, number_of_bits});
  list.push_back({"length", {"v"}, 1, list_length});
  list.push_back({"get_list_length", {"v"}, 1, list_length});
}

double finite(const Value& value) {
  const double it = number(value);
  if (!std::isfinite(it)) throw ScriptError{"Value error: a number is not finite"};
  return it;
}

double finite_or(const BuiltinCall& call, std::size_t i, double preset) {
  return call.has(i) ? finite(arg(call, i)) : preset;
}

double within(double value, double min, double max, const char* what) {
  if (value >= min && value <= max) return value;
  throw ScriptError{concat("Value error: ", what, " goes from ", min, " to ", max, ", got ", value)};
}

std::vector<Builtin> language_functions() {
  std::vector<Builtin> list;
  add_math(list);
  add_text(list);
  add_poses(list);
  list.push_back({"sync", {}, 0, sync_step});
  list.push_back({"assert", {"condition"}, 1, check});
  list.push_back({"struct", {}, 0, sync_step, true});
  return list;
}

Library::Library(std::vector<Builtin> functions) : functions_(std::move(functions)) {
  std::sort(functions_.begin(), functions_.end(),
            [](const Builtin& a, const Builtin& b) { return std::strcmp(a.name, b.name) < 0; });
}

int Library::index(const std::string& name) const {
  const auto it = std::lower_bound(
      functions_.begin(), functions_.end(), name,
      [](const Builtin& builtin, const std::string& wanted) { return builtin.name < wanted; });
  return it != functions_.end() && it->name == name ? static_cast<int>(it - functions_.begin()) : -1;
}

}  // namespace stonestack::urscript
