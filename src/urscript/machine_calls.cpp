// How a machine enters and leaves functions, built-in ones and threads.
#include <algorithm>
#include <iterator>

#include "stonestack/core/error.hpp"
#include "urscript/machine.hpp"

namespace stonestack::urscript {
namespace {

std::vector<Value> take(std::vector<Value>& stack, std::size_t count) {
  const auto first = stack.end() - static_cast<std::ptrdiff_t>(count);
  std::vector<Value> values(std::make_move_iterator(first), std::make_move_iterator(stack.end()));
  stack.erase(first, stack.end());
  return values;
}

constexpr int kStartOfThread = 10;  // effort

[[noreturn]] void wrong_arguments(const CallSite& site) {
  throw ScriptError{concat("Type error: wrong arguments for ", site.name)};
}

}  // namespace

bool Machine::call(int id, Thread& thread, const CallSite& site, bool as_thread) {
  if (as_thread) {
    if (site.target < 0 || !program_.functions[at(site.target)].thread)
      throw ScriptError{"Type error: " + site.name + " is not a thread"};
    if (static_cast<int>(threads_.size()) >= limits_.threads) throw ScriptError{"Too many threads"};
    charge(kStartOfThread);
    Thread started;
    started.computes_since = started.last_turn = steps_;
    started.frames.push_back(enter(thread, site));
    const int handle = next_id_++;
    thread.stack.emplace_back(ThreadHandle{handle});
    threads_.emplace(handle, std::move(started));
    return true;
  }
  if (site.target < 0) return call_builtin(id, thread, site);
  if (static_cast<int>(thread.frames.size()) >= limits_.deepest_call)
    throw ScriptError{"Too many nested calls"};
  thread.frames.push_back(enter(thread, site));
  return true;
}

Machine::Frame Machine::enter(Thread& caller, const CallSite& site) {
  const Function& callee = program_.functions[at(site.target)];
  auto scope = std::make_shared<Scope>();
  scope->function = site.target;
  for (auto outer = caller.frames.back().scope; outer; outer = outer->parent)
    if (outer->function == callee.parent) {
      scope->parent = outer;
      break;
    }
  auto values = take(caller.stack, at(site.positional) + site.keywords.size());
  charge(static_cast<int>(callee.parameters.size() * (1 + site.keywords.size())));
  if (at(site.positional) > callee.parameters.size()) wrong_arguments(site);
  for (std::size_t i = 0; i < callee.parameters.size(); ++i) {
    const auto& parameter = callee.parameters[i];
    const auto key =
        std::find(site.keywords.begin(), site.keywords.end(), program_.names[at(parameter.name)]);
    std::optional<Value> value = parameter.preset;
    if (i < at(site.positional))
      value = std::move(values[i]);
    else if (key != site.keywords.end())
      value = std::move(values[at(site.positional) + static_cast<std::size_t>(key - site.keywords.begin())]);
    if (!value) wrong_arguments(site);
    scope->variables.emplace_back(parameter.name, std::move(*value));
  }
  return {site.target, 0, scope};
}

bool Machine::call_builtin(int id, Thread& thread, const CallSite& site) {
  const Builtin& builtin = (*library_)[site.builtin];
  auto values = take(thread.stack, at(site.positional) + site.keywords.size());
  charge(builtin.effort);
  for (const auto& value : values) charge(weight(value));
  if (builtin.names_anything) {
    if (site.positional > 0 || site.keywords.empty()) wrong_arguments(site);
    Fields fields;
    for (std::size_t k = 0; k < values.size(); ++k)
      fields.push_back({site.keywords[k], std::move(values[k])});
    thread.stack.emplace_back(std::move(fields));
    check_size(thread.stack.back());
    return true;
  }
  std::vector<Value> arguments(builtin.parameters.size());
  if (at(site.positional) > arguments.size()) wrong_arguments(site);
  std::move(values.begin(), values.begin() + site.positional, arguments.begin());
  for (std::size_t k = 0; k < site.keywords.size(); ++k) {
    const auto parameter = std::find(builtin.parameters.begin(), builtin.parameters.end(), site.keywords[k]);
    if (parameter == builtin.parameters.end()) wrong_arguments(site);
    arguments[static_cast<std::size_t>(parameter - builtin.parameters.begin())] =
        std::move(values[at(site.positional) + k]);
  }
  for (std::size_t i = 0; i < builtin.required; ++i)
    if (std::holds_alternative<std::monostate>(arguments[i].is)) wrong_arguments(site);
  BuiltinCall made{*host_, *this, id, arguments};
  Outcome outcome = builtin.call(made);
  if (outcome.wait) {
    thread.wait = std::move(outcome.wait);
    return false;
  }
  check_size(outcome.value);
  charge(weight(outcome.value));
  thread.stack.push_back(std::move(outcome.value));
  return true;
}

bool Machine::leave(int id, Thread& thread) {
  Value value = pop(thread);
  thread.frames.pop_back();
  if (!thread.frames.empty()) {
    thread.stack.push_back(std::move(value));
    return true;
  }
  if (id == main_)
    state_ = State::kEnded;
  else
    kill(id);
  return false;
}

bool Machine::join(int id, Thread& thread, int other) {
  if (!is_alive(other) || other == id) {
    thread.stack.emplace_back();
    return true;
  }
  thread.wait = [this, other]() -> std::optional<Value> {
    if (is_alive(other)) return std::nullopt;
    return Value();
  };
  return false;
}

}  // namespace stonestack::urscript
