#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "stonestack/core/rooms.hpp"

namespace stonestack::urscript {

/// Tokens of one script. Compiling holds up the controller's next step, so its length is bounded: a
/// trajectory of ten minutes at 125 Hz, written out, has a tenth.
inline constexpr std::size_t kMaxTokens = 500'000;

enum class TokenKind {
  kName,
  kInteger,
  kFloat,
  kString,
  kSymbol,   ///< ( ) [ ] { } , : = == != < > <= >= + - * / %
  kPose,     ///< p[
  kNewLine,  ///< end of a statement; none inside brackets or after an operator
  kEnd
};

struct Token {
  TokenKind kind = TokenKind::kEnd;
  std::string text;  ///< without the quotes of a string
  double number = 0.0;
  int line = 0;    ///< from 1
  int column = 0;  ///< from 1
};

/// A program cannot be understood; `text` is what the controller says.
struct CompileError {
  int line = 0;
  int column = 0;
  std::string text;
};

/// "syntax_error_on_line:4:<that line>:", as the primary port reports it; of a long line its beginning.
[[nodiscard]] CompileError syntax_error(std::string_view source, int line, int column);

/// Cuts a script into tokens. Comments (#) and PolyScope's node marks (lines starting with $) are left out.
/// Throws CompileError, also for more than kMaxTokens.
[[nodiscard]] std::vector<Token> cut(std::string_view source);

/// How much deeper nested the blocks are after this line than before (def, sec, thread, if, while: +1; end:
/// -1). For finding the end of a program in a stream of lines.
[[nodiscard]] int block_balance(std::string_view line);
/// A line that opens a program: def, sec or thread.
[[nodiscard]] bool opens_program(std::string_view line);

}  // namespace stonestack::urscript
