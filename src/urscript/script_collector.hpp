#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "stonestack/core/rooms.hpp"

namespace stonestack::urscript {

/// Characters of the longest program that runs. A longer one is cut off somewhere behind that.
inline constexpr std::size_t kLongestScript = 4'000'000;

/// Cuts what a script port receives into programs (`def` to its `end`) and single lines.
class ScriptCollector {
 public:
  /// Whole programs and lines, in their order; empty lines and comments left out.
  [[nodiscard]] std::vector<std::string> feed(std::string_view bytes);
  /// A program is begun and not ended: what is there of it, which is then forgotten. For the controller that
  /// has waited long enough to call it a syntax error.
  [[nodiscard]] std::string give_up();
  [[nodiscard]] bool inside_program() const { return depth_ > 0; }

 private:
  void take_line(std::string line, std::vector<std::string>& whole);

  std::string line_;
  std::string program_;
  int depth_ = 0;
};

}  // namespace stonestack::urscript
