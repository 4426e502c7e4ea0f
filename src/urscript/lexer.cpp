#include "urscript/lexer.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>

namespace stonestack::urscript {
namespace {

constexpr std::size_t kLongestQuote = 256;  // characters of a script in an error

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
  auto text = source.substr(0, std::min(source.find('\n'), kLongestQuote));
  while (!text.empty() && text.back() == '\r') text.remove_suffix(1);
  return text;
}

// `p[` begins a pose, unless there is no comma inside: then it is an element of a variable called p.
std::vector<Token> part_poses_from_indices(std::vector<Token> tokens) {
  std::vector<std::pair<std::size_t, bool>> open;  // bracket, has a comma
  std::vector<bool> is_index(tokens.size());
  std::size_t count = 0;
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    const Token& token = tokens[i];
    if (token.kind != TokenKind::kSymbol && token.kind != TokenKind::kPose) continue;
    const std::string& text = token.text;
    if (token.kind == TokenKind::kPose || text == "(" || text == "[" || text == "{") {
      open.emplace_back(i, false);
    } else if (text == "," && !open.empty()) {
      open.back().second = true;
    } else if ((text == ")" || text == "]" || text == "}") && !open.empty()) {
      const auto [at, comma] = open.back();
      open.pop_back();
      if (tokens[at].kind == TokenKind::kPose && !comma) is_index[at] = ++count > 0;
    }
  }
  if (count == 0) return tokens;
  std::vector<Token> parted;
  parted.reserve(tokens.size() + count);
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    Token& token = tokens[i];
    if (is_index[i]) {
      parted.push_back({TokenKind::kName, "p", 0.0, token.line, token.column});
      token = {TokenKind::kSymbol, "[", 0.0, token.line, token.column + 1};
    }
    parted.push_back(std::move(token));
  }
  return parted;
}

class Cutter {
 public:
  explicit Cutter(std::string_view source) : source_(source) {}

  std::vector<Token> run() {
    while (at_ < source_.size()) step();
    push(TokenKind::kNewLine, "");
    push(TokenKind::kEnd, "");
    return part_poses_from_indices(std::move(tokens_));
  }

 private:
  [[nodiscard]] char peek(std::size_t ahead = 0) const {
    return at_ + ahead < source_.size() ? source_[at_ + ahead] : '\0';
  }
  [[nodiscard]] int column() const { return static_cast<int>(at_ - line_start_) + 1; }

  void push(TokenKind kind, std::string text, double number = 0.0) {
    if (tokens_.size() >= kMaxTokens)
      throw CompileError{line_, column(),
                         "script too long: more than " + std::to_string(kMaxTokens) +
                             " words, numbers and signs; make it shorter"};
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

  // A statement goes on inside brackets and after an operator. (ur_rtde puts numbers into its script below a
  // line that ends with `= # comment`.)
  void new_line() {
    static constexpr std::array<std::string_view, 16> kContinuing{
        "=", "+", "-", "*", "/", "%", ",", "==", "!=", "<", ">", "<=", ">=", "and", "or", "xor"};
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
      if (length == 2) throw syntax_error(source_, line_, column());
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
    if (std::string_view("()[]{},:=<>+-*/%.").find(c) == std::string_view::npos)
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
  int balance = 0;
  for (std::size_t at = 0; at < line.size() && line[at] != '#';) {
    if (line[at] == '"' || line[at] == '\'') {
      const auto close = line.find(line[at], at + 1);
      if (close == std::string_view::npos) break;
      at = close + 1;
    } else if (starts_name(line[at])) {
      std::size_t length = 1;
      while (at + length < line.size() && continues_name(line[at + length])) ++length;
      const auto word = line.substr(at, length);
      if (word == "def" || word == "sec" || word == "thread" || word == "if" || word == "while") ++balance;
      if (word == "end") --balance;
      at += length;
    } else {
      ++at;
    }
  }
  return balance;
}

bool opens_program(std::string_view line) {
  const auto word = first_word(line);
  return word == "def" || word == "sec" || word == "thread";
}

}  // namespace stonestack::urscript
