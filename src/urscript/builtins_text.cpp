#include <cmath>
#include <cstdlib>

#include "urscript/builtins.hpp"

namespace stonestack::urscript {
namespace {

Outcome concatenate(BuiltinCall& call) {
  std::string joined = print(arg(call, 0)) + print(arg(call, 1));
  if (joined.size() > kLongestText) throw ScriptError{"A string has too many characters"};
  return Value(std::move(joined));
}

Outcome substring(BuiltinCall& call) {
  const std::string& source = text(arg(call, 0));
  const long long index = integer(arg(call, 1));
  const long long count = call.has(2) ? integer(arg(call, 2)) : -1;
  if (index < 0 || static_cast<std::size_t>(index) > source.size())
    throw ScriptError{"Index out of bounds in str_sub"};
  return Value(source.substr(static_cast<std::size_t>(index),
                             count < 0 ? std::string::npos : static_cast<std::size_t>(count)));
}

Outcome find_text(BuiltinCall& call) {
  const long long from = call.has(2) ? integer(arg(call, 2)) : 0;
  if (from < 0) throw ScriptError{"Index out of bounds in str_find"};
  const auto at = text(arg(call, 0)).find(text(arg(call, 1)), static_cast<std::size_t>(from));
  return Value(at == std::string::npos ? -1LL : static_cast<long long>(at));
}

Outcome to_number(BuiltinCall& call) {
  const std::string& source = text(arg(call, 0));
  char* end = nullptr;
  const double value = std::strtod(source.c_str(), &end);
  if (source.empty() || *end != '\0' || !std::isfinite(value))
    throw ScriptError{"Value error: \"" + source.substr(0, 40) + "\" is not a number"};
  if (source.find_first_of(".eE") == std::string::npos && std::abs(value) < 2147483648.0)
    return Value(static_cast<long long>(value));
  return Value(value);
}

}  // namespace

void add_text(std::vector<Builtin>& list) {
  list.push_back({"str_cat", {"op1", "op2"}, 2, concatenate});
  list.push_back({"str_sub", {"src", "index", "len"}, 2, substring});
  list.push_back({"str_find", {"src", "target", "start_from"}, 2, find_text});
  list.push_back({"str_at", {"src", "index"}, 2, [](BuiltinCall& c) {
                    static_cast<void>(text(arg(c, 0)));
                    return Outcome(element(arg(c, 0), integer(arg(c, 1))));
                  }});
  list.push_back({"str_len", {"str"}, 1, [](BuiltinCall& c) {
                    return Outcome(Value(static_cast<long long>(text(arg(c, 0)).size())));
                  }});
  list.push_back(
      {"str_empty", {"str"}, 1, [](BuiltinCall& c) { return Outcome(Value(text(arg(c, 0)).empty())); }});
  list.push_back({"to_num", {"str"}, 1, to_number});
  list.push_back({"to_str", {"val"}, 1, [](BuiltinCall& c) { return Outcome(Value(print(arg(c, 0)))); }});
}

}  // namespace stonestack::urscript
