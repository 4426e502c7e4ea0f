#pragma once
#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "urscript/program.hpp"

namespace stonestack::urscript {

class Machine;

inline std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

/// Looked at once a control step; the value with which the script goes on, or nothing yet. Throws
/// ScriptError.
using Wait = std::function<std::optional<Value>()>;

/// Result of a built-in function: a value at once, or something to wait for.
struct Outcome {
  Value value;
  Wait wait;
  Outcome(Value at_once) : value(std::move(at_once)) {}  // NOLINT: so that functions return values
  Outcome(Wait until) : wait(std::move(until)) {}        // NOLINT
};

/// Target of the built-in functions: the controller that runs the program derives from it. The machine only
/// passes it on.
class Host {
 protected:
  ~Host() = default;
};

/// One call of a built-in function: arguments in the order of its parameters, absent ones monostate.
struct BuiltinCall {
  Host& host;
  Machine& machine;
  int thread = 0;
  std::vector<Value>& arguments;

  [[nodiscard]] bool has(std::size_t i) const {
    return i < arguments.size() && !std::holds_alternative<std::monostate>(arguments[i].is);
  }
  [[nodiscard]] double number_or(std::size_t i, double preset) const {
    return has(i) ? number(arguments[i]) : preset;
  }
};

struct Builtin {
  const char* name;
  std::vector<const char*> parameters;
  std::size_t required;
  Outcome (*call)(BuiltinCall& call);
  bool names_anything = false;  ///< struct: its arguments' names are the caller's; `call` is not used
  int effort = 0;               ///< beyond an instruction's, of kStepQuota
};

/// The functions that a program may call without defining them.
class Library {
 public:
  explicit Library(std::vector<Builtin> functions);
  /// Number of the function of that name or -1.
  [[nodiscard]] int index(const std::string& name) const;
  [[nodiscard]] const Builtin& operator[](int index) const {
    return functions_[static_cast<std::size_t>(index)];
  }

 private:
  std::vector<Builtin> functions_;  // sorted by name
};

/// Effort that all programs together may take in a control step: an instruction is 1, what it copies comes on
/// top. Some milliseconds of the host, whatever the script.
inline constexpr int kStepQuota = 10000;

struct MachineLimits {
  int patience = 100;      ///< control steps that a thread may compute on end; then its loop is endless
  int deepest_call = 100;  ///< calls within calls
  int threads = 64;
};

/// Runs one program, a control step at a time. Threads take turns; each runs until it waits, ends or has used
/// up its share of the step's quota. Those that wait come before those that compute; who had no turn because
/// the quota was used up is first in the next step. Inside a critical section a thread goes on alone in the
/// next steps when its share is used up; a thread that waits there (motion, sleep, sync, join, socket) lets
/// the others run, critical sections or not: UR's own client library joins, reads sockets and moves inside
/// them while other threads must go on.
class Machine {
 public:
  enum class State { kRunning, kEnded, kFailed };

  /// `library` is the one that the program was compiled with; it and `host` must outlive the machine.
  Machine(Program program, const Library& library, Host& host, const MachineLimits& limits = {});

  /// One control step. Never throws; a run-time error ends the program.
  State step(int quota = kStepQuota);
  /// Part of its quota that the last step used; may be more by one instruction.
  [[nodiscard]] int spent() const { return spent_; }
  [[nodiscard]] State state() const { return state_; }
  /// Line, column and text of what made it fail.
  [[nodiscard]] const CompileError& error() const { return error_; }
  [[nodiscard]] const Program& program() const { return program_; }
  /// Line that the main thread is at.
  [[nodiscard]] int line() const;
  [[nodiscard]] bool is_alive(int thread) const { return threads_.count(thread) > 0; }
  void kill(int thread);

 private:
  struct Scope {
    int function = 0;
    std::vector<std::pair<int, Value>> variables;
    std::shared_ptr<Scope> parent;
  };
  struct Frame {
    int function = 0;
    std::size_t at = 0;
    std::shared_ptr<Scope> scope;
  };
  struct Thread {
    std::vector<Frame> frames;
    std::vector<Value> stack;
    Wait wait;
    long computes_since = 0;   // step of its start or last wait
    long last_turn = 0;        // step
    bool critical = false;     // inside a critical section
    bool interrupted = false;  // its share of the step was used up
  };

  [[nodiscard]] std::vector<int> turns() const;
  void run(int id, Thread& thread, int share);
  /// False when the thread waits or has ended.
  bool execute(int id, Thread& thread, const Instruction& it);
  bool call(int id, Thread& thread, const CallSite& site, bool as_thread);
  bool call_builtin(int id, Thread& thread, const CallSite& site);
  [[nodiscard]] Frame enter(Thread& caller, const CallSite& site);
  bool leave(int id, Thread& thread);
  void run_and_mark(int id, int share);
  void charge(int effort) { spent_ += effort; }
  bool join(int id, Thread& thread, int other);
  [[nodiscard]] Value* find_in(std::vector<std::pair<int, Value>>& variables, int name);
  [[nodiscard]] Value* find(Frame& frame, int name);
  void store(Frame& frame, const Instruction& it, Value value);
  void store_element(Thread& thread, const Instruction& it);
  [[nodiscard]] Value pop(Thread& thread);
  void fail(const Thread& thread, const std::string& text);

  Program program_;
  const Library* library_;
  Host* host_;
  MachineLimits limits_;
  State state_ = State::kRunning;
  CompileError error_;
  std::vector<std::pair<int, Value>> globals_;
  std::map<int, Thread> threads_;
  int main_ = 1;
  int next_id_ = 2;
  int alone_ = 0;  // thread that was interrupted inside a critical section
  long steps_ = 0;
  int spent_ = 0;  // effort of this step
};

}  // namespace stonestack::urscript
