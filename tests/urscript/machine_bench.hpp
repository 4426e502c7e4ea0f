#pragma once
#include <string>

#include "urscript/builtins.hpp"

namespace stonestack::urscript {

/// A machine with the functions of the language and two of a host of its own: `textmsg`, and `add_up` for a
/// host that has a state.
struct MachineBench : Host {
  std::string texts, exceptions;
  long long sum = 0;

  static MachineBench& of(const BuiltinCall& call) { return static_cast<MachineBench&>(call.host); }
  static std::vector<Builtin> functions() {
    auto list = language_functions();
    list.push_back({"textmsg", {"s1", "s2"}, 1, [](BuiltinCall& call) {
                      auto& texts = of(call).texts;
                      texts += (texts.empty() ? "" : "|") + print(arg(call, 0)) +
                               (call.has(1) ? print(arg(call, 1)) : "");
                      return Outcome(Value());
                    }});
    list.push_back({"add_up", {"n"}, 1, [](BuiltinCall& call) {
                      of(call).sum += integer(arg(call, 0));
                      return Outcome(Value(of(call).sum));
                    }});
    return list;
  }

  /// .|Texts of textmsg until the program ended, lines joined by |.|.
  std::string output(const std::string& source, int max_steps = 1000) {
    texts.clear();
    exceptions.clear();
    const Library library(functions());
    try {
      Machine machine(compile(source, [&](const std::string& name) { return library.index(name); }), library,
                      *this);
      while (max_steps-- > 0 && machine.state() == Machine::State::kRunning) machine.step();
      note(machine.error());
    } catch (const CompileError& error) {
      note(error);
    }
    return texts;
  }
  /// An expression as textmsg prints it.
  std::string value(const std::string& expression) {
    return output("def v():\n textmsg(" + expression + ")\nend\n");
  }

 private:
  void note(const CompileError& error) {
    if (!error.text.empty())
      exceptions = std::to_string(error.line) + "," + std::to_string(error.column) + "," + error.text;
  }
};

}  // namespace stonestack::urscript
