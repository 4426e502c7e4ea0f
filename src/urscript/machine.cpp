#include "urscript/machine.hpp"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

#include "stonestack/core/error.hpp"

namespace stonestack::urscript {
namespace {

// Against an instruction's effort: elements that are copied, those that are reckoned with, variables that are
// looked at until the right one is found.
constexpr int kCopied = 4, kReckoned = 2, kCompared = 64;

Value make_pose_value(const std::vector<Value>& six_numbers) {
  PoseVector pose;
  for (int i = 0; i < 6; ++i) pose[i] = number(six_numbers[at(i)]);
  return pose;
}

}  // namespace

Machine::Machine(Program program, const Library& library, Host& host, const MachineLimits& limits)
    : program_(std::move(program)), library_(&library), host_(&host), limits_(limits) {
  Thread thread;
  thread.frames.push_back({0, 0, std::make_shared<Scope>()});
  for (const auto& parameter : program_.functions[0].parameters)
    thread.frames.back().scope->variables.emplace_back(parameter.name, parameter.preset.value_or(Value()));
  threads_.emplace(main_, std::move(thread));
}

std::vector<int> Machine::turns() const {
  std::vector<int> ids;
  for (const auto& [id, thread] : threads_) ids.push_back(id);
  const auto rank = [this](int id) {
    const Thread& thread = threads_.at(id);
    return std::tuple(id != alone_, thread.last_turn, thread.interrupted, id);
  };
  std::sort(ids.begin(), ids.end(), [&](int a, int b) { return rank(a) < rank(b); });
  return ids;
}

Machine::State Machine::step(int quota) {
  ++steps_;
  spent_ = 0;
  const auto ids = turns();
  const auto computes = [this](int id) {
    const auto it = threads_.find(id);
    return it != threads_.end() && !it->second.wait;
  };
  auto computing = std::count_if(ids.begin(), ids.end(), computes);
  for (const int id : ids) {
    const auto others = computes(id) ? --computing : computing;
    run_and_mark(id, (quota - spent_) / static_cast<int>(1 + std::max<std::ptrdiff_t>(0, others)));
    if (alone_ != 0 || state_ != State::kRunning || spent_ >= quota) break;
  }
  if (state_ != State::kRunning) threads_.clear();
  return state_;
}

void Machine::run_and_mark(int id, int share) {
  alone_ = 0;
  auto it = threads_.find(id);  // another one may have killed it in this step
  if (it == threads_.end()) return;
  it->second.last_turn = steps_;
  run(id, it->second, share);
  it = threads_.find(id);
  if (it != threads_.end() && it->second.critical && it->second.interrupted) alone_ = id;
}

int Machine::line() const {
  const auto it = threads_.find(main_);
  if (it == threads_.end() || it->second.frames.empty()) return 0;
  const auto& frame = it->second.frames.front();
  const auto& code = program_.functions[at(frame.function)].code;
  return code.empty() ? 0 : code[std::min(frame.at, code.size() - 1)].line;
}

void Machine::kill(int id) {
  const auto it = threads_.find(id);
  if (it == threads_.end()) return;
  if (id == main_) {
    state_ = State::kEnded;
    return;
  }
  threads_.erase(it);
}

void Machine::fail(const Thread& thread, const std::string& text) {
  state_ = State::kFailed;
  const auto& frame = thread.frames.back();
  const auto& code = program_.functions[at(frame.function)].code;
  const auto& it = code[frame.at > 0 ? frame.at - 1 : 0];
  error_ = {it.line, it.column, text};
}

void Machine::run(int id, Thread& thread, int share) {
  const int end = spent_ + std::max(1, share);
  thread.interrupted = false;
  try {
    if (thread.wait) {
      charge(1);
      auto value = thread.wait();
      if (!value) return;
      thread.wait = nullptr;
      thread.computes_since = steps_;
      thread.stack.push_back(std::move(*value));
    }
    while (spent_ < end) {
      charge(1);
      Frame& frame = thread.frames.back();
      const Instruction it = program_.functions[at(frame.function)].code[frame.at++];
      if (!execute(id, thread, it)) return;
    }
    thread.interrupted = true;
    if (steps_ - thread.computes_since >= limits_.patience) fail(thread, "Infinite loop detected");
  } catch (const ScriptError& error) {
    fail(thread, error.text);
  } catch (const std::exception& error) {
    fail(thread, concat("Internal error: ", error.what()));
  }
}

Value Machine::pop(Thread& thread) {
  Value value = std::move(thread.stack.back());
  thread.stack.pop_back();
  return value;
}

Value* Machine::find_in(std::vector<std::pair<int, Value>>& variables, int name) {
  const auto it = std::find_if(variables.begin(), variables.end(),
                               [name](const auto& variable) { return variable.first == name; });
  charge(static_cast<int>(it - variables.begin()) / kCompared);
  return it == variables.end() ? nullptr : &it->second;
}

Value* Machine::find(Frame& frame, int name) {
  for (Scope* scope = frame.scope.get(); scope; scope = scope->parent.get())
    if (Value* value = find_in(scope->variables, name)) return value;
  return find_in(globals_, name);
}

void Machine::store(Frame& frame, const Instruction& it, Value value) {
  check_size(value);
  charge(weight(value) / kCopied);
  auto& own = frame.scope->variables;
  Value* place = it.op == Op::kStore        ? find(frame, it.a)
                 : it.op == Op::kStoreLocal ? find_in(own, it.a)
                                            : find_in(globals_, it.a);
  if (place) {
    *place = std::move(value);
  } else {
    (it.op == Op::kStoreGlobal ? globals_ : own).emplace_back(it.a, std::move(value));
  }
}

void Machine::store_element(Thread& thread, const Instruction& it) {
  Value value = pop(thread);
  std::vector<Value> keys(at(it.b));
  for (auto key = keys.rbegin(); key != keys.rend(); ++key) *key = pop(thread);
  Value* place = find(thread.frames.back(), it.a);
  if (!place) throw ScriptError{"Variable '" + program_.names[at(it.a)] + "' has no value"};
  for (std::size_t k = 0; k + 1 < keys.size(); ++k) place = &member(*place, keys[k]);
  set_member(*place, keys.back(), std::move(value));
  charge(weight(*place) / kCopied);
}

bool Machine::execute(int id, Thread& thread, const Instruction& it) {
  auto& stack = thread.stack;
  Frame& frame = thread.frames.back();
  switch (it.op) {
    case Op::kConstant:
      stack.push_back(program_.constants[at(it.a)]);
      charge(weight(stack.back()) / kCopied);
      return true;
    case Op::kLoad: {
      const Value* value = find(frame, it.a);
      if (!value) throw ScriptError{"Variable '" + program_.names[at(it.a)] + "' has no value"};
      stack.push_back(*value);
      charge(weight(*value) / kCopied);
      return true;
    }
    case Op::kStore:
    case Op::kStoreLocal:
    case Op::kStoreGlobal:
      store(frame, it, pop(thread));
      return true;
    case Op::kStoreElement:
      store_element(thread, it);
      return true;
    case Op::kIndex: {
      const Value key = pop(thread);
      stack.back() = member(std::as_const(stack.back()), key);
      return true;
    }
    case Op::kPop:
      stack.pop_back();
      return true;
    case Op::kJump:
      frame.at = at(it.a);
      return true;
    case Op::kJumpIfFalse:
      if (!truth(pop(thread))) frame.at = at(it.a);
      return true;
    case Op::kJumpAnd:
    case Op::kJumpOr:
      stack.back() = truth(stack.back());
      if (truth(stack.back()) == (it.op == Op::kJumpOr))
        frame.at = at(it.a);
      else
        stack.pop_back();
      return true;
    case Op::kNot:
      stack.back() = !truth(stack.back());
      return true;
    case Op::kNegate:
      charge(weight(stack.back()) / kReckoned);
      stack.back() = negate(stack.back());
      return true;
    case Op::kBinary: {
      const Value b = pop(thread);
      charge((weight(stack.back()) + weight(b)) / kReckoned);
      stack.back() = apply(static_cast<Operator>(it.a), stack.back(), b);
      return true;
    }
    case Op::kMakeList: {
      List list(std::make_move_iterator(stack.end() - it.a), std::make_move_iterator(stack.end()));
      stack.resize(stack.size() - at(it.a));
      stack.emplace_back(std::move(list));
      check_size(stack.back());
      charge(weight(stack.back()) / kCopied);
      return true;
    }
    case Op::kMakePose: {
      const std::vector<Value> numbers(stack.end() - 6, stack.end());
      stack.resize(stack.size() - 6);
      stack.push_back(make_pose_value(numbers));
      return true;
    }
    case Op::kCall:
    case Op::kRun:
      return call(id, thread, program_.calls[at(it.a)], it.op == Op::kRun);
    case Op::kReturn:
      return leave(id, thread);
    case Op::kKill:
    case Op::kJoin: {
      const Value value = pop(thread);
      const auto* handle = std::get_if<ThreadHandle>(&value.is);
      const int other = handle ? handle->id : 0;  // programs initialise their handles with 0
      if (it.op == Op::kKill) {
        kill(other);
        return threads_.count(id) > 0 && state_ == State::kRunning;
      }
      return join(id, thread, other);
    }
    case Op::kHalt:
      state_ = State::kEnded;
      return false;
    case Op::kEnterCritical:
    case Op::kExitCritical:
      thread.critical = it.op == Op::kEnterCritical;
      return true;
  }
  return true;
}

}  // namespace stonestack::urscript
