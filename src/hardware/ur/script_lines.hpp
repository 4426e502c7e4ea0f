#pragma once
#include <string>
#include <utility>

#include "hardware/ur/script_text.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/hardware/ur/script_writer.hpp"

namespace stonestack::hardware {

/// A program in the making: its lines, with their indentation, and what they depend on.
class ScriptLines {
 public:
  explicit ScriptLines(const ScriptContext& context)
      : context_(context), base_(first_register(context.version)) {}

  /// `depth` levels of indentation; the parts as `concat` writes them.
  template <class... Parts>
  void add(int depth, const Parts&... parts) {
    text_ += std::string(static_cast<std::size_t>(2 * depth), ' ') + concat(parts...) + "\n";
  }
  /// Number of the n-th register in use.
  [[nodiscard]] int reg(int n) const { return base_ + n; }
  [[nodiscard]] const ScriptContext& context() const { return context_; }
  [[nodiscard]] const ScriptOptions& options() const { return context_.options; }
  /// of a control step [s]: an expression of URScript.
  [[nodiscard]] std::string step_time() const {
    constexpr UrVersion kFirstWithSteptime{5, 4, 0, 0};
    const UrVersion& version = context_.version;
    return version.has({}, kFirstWithSteptime) ? "get_steptime()" : to_script(1.0 / version.control_rate());
  }
  /// The program; leaves none.
  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  const ScriptContext& context_;
  int base_;
  std::string text_;
};

/// As programs compare and report it.
inline int number(ScriptEnd end) {
  return static_cast<int>(end);
}

}  // namespace stonestack::hardware
