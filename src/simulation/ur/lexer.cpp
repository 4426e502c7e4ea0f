#include "simulation/ur/lexer.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>

namespace stonestack::urscript {
namespace {

bool starts_name(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) || c == '_';
}
bool continues_name(char c) {
  return starts_name(c) || std::isdigit(static_cast<unsigned char>(c));
}
bool is_digit(char c) {
  return std::isdigit(static_cast<unsigned char>(c));
}

std::string_view line_of(std::string_view source, int line) {
  for (int n = 1; n < line; ++n) {
    const auto end = source.find('\n');
    if (end == std::string_view::npos) return {};
    source.remove_prefix(end + 1);
  }
  auto text = source.substr(0, source.find('\n'));
  while (!text.empty() && text.back() == '\r') text.remove_suffix(1);
  return text;
}

class Cutter {
 public:
  explicit Cutter(std::string_view source) : source_(source) {}

  std::vector<Token> run() {
    while (at_ < source_.size()) step();
    push(TokenKind::kNewLine, "");
    push(TokenKind::kEnd, "");
    return std::move(tokens_);
  }

 private:
  [[nodiscard]] char peek(std::size_t ahead = 0) const {
    return at_ + ahead < source_.size() ? source_[at_ + ahead] : '\0';
  }
  [[nodiscard]] int column() const { return static_cast<int>(at_ - line_start_) + 1; }

  void push(TokenKind kind, std::string text, double number = 0.0) {
    tokens_.push_back({kind, std::move(text), number, line_, column()});
  }

  void step() {
    const char c = peek();
    if (c == '\n') return new_line();
    if (c == ' ' || c == '\t' || c == '\r' || c == ';') {
      ++at_;
    } else if (c == '#' || (c == '$' && at_line_start())) {
      while (at_ < source_.size() && peek() != '\n') ++at_;
    } else if (c == 'p' && peek(1) == '[') {
      push(TokenKind::kPose, "p[");
      at_ += 2;
      ++open_;
    } else if (starts_name(c)) {
      name();
    } else if (is_digit(c) || (c == '.' && is_digit(peek(1)))) {
      numeral();
    } else if (c == '"' || c == '\'') {
      string(c);
    } else {
      symbol();
    }
  }

  [[nodiscard]] bool at_line_start() const {
    return std::all_of(source_.begin() + static_cast<std::ptrdiff_t>(line_start_),
                       source_.begin() + static_cast<std::ptrdiff_t>(at_),
                       [](char c) { return c == ' ' || c == '\t'; });
  }

  // A statement goes on inside brackets and after an operator.
  void new_line() {
    static constexpr std::array<std::string_view, 15> kContinuing{
        "+", "-", "*", "/", "%", ",", "==", "!=", "<", ">", "<=", ">=", "and", "or", "xor"};
    const bool first = tokens_.empty() || tokens_.back().kind == TokenKind::kNewLine;
    const bool goes_on = open_ > 0 || (!first && tokens_.back().kind != TokenKind::kString &&
                                       std::find(kContinuing.begin(), kContinuing.end(),
                                                 tokens_.back().text) != kContinuing.end());
    if (!first && !goes_on) push(TokenKind::kNewLine, "");
    ++at_;
    ++line_;
    line_start_ = at_;
  }

  void name() {
    std::size_t length = 1;
    while (continues_name(peek(length))) ++length;
    push(TokenKind::kName, std::string(source_.substr(at_, length)));
    at_ += length;
  }

  void numeral() {
    std::size_t length = 0;
    bool whole = true;
    if (peek() == '0' && (peek(1) == 'x' || peek(1) == 'X')) {
      length = 2;
      while (std::isxdigit(static_cast<unsigned char>(peek(length)))) ++length;
    } else {
      while (is_digit(peek(length))) ++length;
      if (peek(length) == '.') {
        whole = false;
        ++length;
        while (is_digit(peek(length))) ++length;
      }
      if (peek(length) == 'e' || peek(length) == 'E') {
        std::size_t digits = length + 1;
        if (peek(digits) == '+' || peek(digits) == '-') ++digits;
        if (is_digit(peek(digits))) {
          whole = false;
          for (length = digits; is_digit(peek(length));) ++length;
        }
      }
    }
    const std::string text(source_.substr(at_, length));
    if (length > 64 || continues_name(peek(length))) throw syntax_error(source_, line_, column());
    const double value = std::strtod(text.c_str(), nullptr);
    push(whole && value <= 4294967295.0 ? TokenKind::kInteger : TokenKind::kFloat, text, value);
    at_ += length;
  }

  void string(char quote) {
    std::size_t length = 1;
    while (peek(length) != quote) {
      if (peek(length) == '\n' || at_ + length >= source_.size())
        throw syntax_error(source_, line_, column());
      ++length;
    }
    push(TokenKind::kString, std::string(source_.substr(at_ + 1, length - 1)));
    at_ += length + 1;
  }

  void symbol() {
    static constexpr std::array<std::string_view, 4> kDouble{"==", "!=", "<=", ">="};
    const auto two = source_.substr(at_, 2);
    if (std::find(kDouble.begin(), kDouble.end(), two) != kDouble.end()) {
      push(TokenKind::kSymbol, std::string(two));
      at_ += 2;
      return;
    }
    const char c = peek();
    if (std::string_view("()[]{},:=<>+-*/%").find(c) == std::string_view::npos)
      throw syntax_error(source_, line_, column());
    if (c == '(' || c == '[' || c == '{') ++open_;
    if ((c == ')' || c == ']' || c == '}') && open_ > 0) --open_;
    push(TokenKind::kSymbol, std::string(1, c));
    ++at_;
  }

  std::string_view source_;
  std::size_t at_ = 0, line_start_ = 0;
  int line_ = 1, open_ = 0;
  std::vector<Token> tokens_;
};

std::string_view first_word(std::string_view line) {
  const auto start = line.find_first_not_of(" \t\r");
  if (start == std::string_view::npos) return {};
  line.remove_prefix(start);
  std::size_t length = 0;
  while (length < line.size() && continues_name(line[length])) ++length;
  return line.substr(0, length);
}

}  // namespace

CompileError syntax_error(std::string_view source, int line, int column) {
  return {line, column,
          "syntax_error_on_line:" + std::to_string(line) + ":" + std::string(line_of(source, line)) + ":"};
}

std::vector<Token> cut(std::string_view source) {
  return Cutter(source).run();
}

int block_balance(std::string_view line) {
  const auto word = first_word(line);
  if (word == "def" || word == "sec" || word == "thread" || word == "if" || word == "while") return 1;
  return word == "end" ? -1 : 0;
}

bool opens_program(std::string_view line) {
  const auto word = first_word(line);
  return word == "def" || word == "sec" || word == "thread";
}

}  // namespace stonestack::urscript
