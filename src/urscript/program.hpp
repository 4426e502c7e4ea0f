#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "urscript/lexer.hpp"
#include "urscript/value.hpp"

namespace stonestack::urscript {

enum class Op {
  kConstant,      ///< push constants[a]
  kLoad,          ///< push variable names[a]
  kStore,         ///< pop into names[a]: where it is visible, else into the function's own
  kStoreLocal,    ///< pop into the function's own names[a]
  kStoreGlobal,   ///< pop into the program's names[a]
  kStoreElement,  ///< pop value, then b indices or member names; into an element of names[a]
  kIndex,         ///< pop index or member name, and container; push element
  kPop,
  kJump,         ///< to a
  kJumpIfFalse,  ///< pop; to a
  kJumpAnd,      ///< to a if the top is false, else pop
  kJumpOr,       ///< to a if the top is true, else pop
  kNot,
  kNegate,
  kBinary,    ///< a is the Operator
  kMakeList,  ///< of a values
  kMakePose,  ///< of 6 values
  kCall,      ///< calls[a]
  kRun,       ///< calls[a] as a thread; push its handle
  kReturn,    ///< pop the value to return
  kKill,
  kJoin,  ///< pop a handle, wait, push a value
  kHalt,
  kEnterCritical,
  kExitCritical
};

struct Instruction {
  Op op = Op::kHalt;
  int a = 0;
  int b = 0;
  int line = 0;
  int column = 0;
};

struct Parameter {
  int name = 0;
  std::optional<Value> preset;
};

struct Function {
  std::string name;
  int parent = -1;
  bool thread = false;
  int line = 0;
  std::vector<Parameter> parameters;
  std::vector<Instruction> code;
};

/// `name(a, b, k=c)`: values lie on the stack in the order written.
struct CallSite {
  std::string name;
  int function = 0;  ///< that contains it
  int positional = 0;
  std::vector<std::string> keywords;  ///< of the values after the positional ones
  int line = 0;
  int column = 0;
  int target = -1;   ///< index into functions, or
  int builtin = -1;  ///< into the built-in functions
};

/// A compiled script. functions[0] is its body.
struct Program {
  std::string name;
  bool secondary = false;  ///< `sec`: runs beside the program, may not move the arm
  std::vector<Function> functions;
  std::vector<Value> constants;
  std::vector<std::string> names;
  std::vector<CallSite> calls;
};

/// The number of a built-in function or -1.
using BuiltinIndex = std::function<int(const std::string& name)>;

/// Compiles one script: a single `def`, `sec` or `thread`, or bare statements. Throws CompileError.
[[nodiscard]] Program compile(std::string_view source, const BuiltinIndex& builtin_index);

}  // namespace stonestack::urscript
