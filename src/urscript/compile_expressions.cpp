#include <algorithm>
#include <array>

#include "urscript/compiler.hpp"

namespace stonestack::urscript {
namespace {

constexpr int kDeepest = 80;
constexpr std::size_t kLongestCode = 2'000'000;  // instructions of one function
constexpr std::array kReserved{"and",          "or",       "not",    "xor",    "def",
                               "end",          "sec",      "thread", "if",     "elif",
                               "else",         "while",    "local",  "global", "return",
                               "break",        "continue", "halt",   "run",    "kill",
                               "join",         "True",     "False",  "pass",   "enter_critical",
                               "exit_critical"};
constexpr std::array kBeginning{"def",   "thread", "if",     "elif",   "else",           "end",
                                "while", "local",  "global", "return", "break",          "continue",
                                "halt",  "kill",   "join",   "pass",   "enter_critical", "exit_critical"};

struct Symbol {
  const char* text;
  Operator op;
};

}  // namespace

Depth::Depth(Compiler& compiler, const Token& where) : depth_(&compiler.depth_) {
  if (*depth_ >= kDeepest) compiler.fail(where);
  ++*depth_;
}

const Token& Compiler::peek(std::size_t ahead) const {
  return tokens_[std::min(at_ + ahead, tokens_.size() - 1)];
}

bool Compiler::is(const char* text, std::size_t ahead) const {
  const Token& token = peek(ahead);
  return token.kind != TokenKind::kString && token.text == text;
}

bool Compiler::is_word(const Token& token) const {
  return token.kind == TokenKind::kName &&
         std::find(kReserved.begin(), kReserved.end(), token.text) == kReserved.end();
}

const Token& Compiler::next() {
  const Token& token = peek();
  if (at_ + 1 < tokens_.size()) ++at_;
  return token;
}

bool Compiler::accept(const char* text) {
  if (!is(text)) return false;
  next();
  return true;
}

void Compiler::expect(const char* text) {
  if (!accept(text)) fail(peek());
}

// A new line, or a word that only a statement begins with: `a = 24 global b = 1` is taken.
void Compiler::end_of_statement() {
  if (accept_new_line()) return;
  const bool word = peek().kind == TokenKind::kName &&
                    std::find(kBeginning.begin(), kBeginning.end(), peek().text) != kBeginning.end();
  if (!word) fail(peek());
}

bool Compiler::accept_new_line() {
  if (peek().kind != TokenKind::kNewLine) return false;
  next();
  return true;
}

void Compiler::fail(const Token& token) const {
  throw syntax_error(source_, token.line, token.column);
}

std::size_t Compiler::emit(Op op, int a, int b) {
  auto& code = function().code;
  if (code.size() >= kLongestCode) fail(peek());
  code.push_back({op, a, b, here_.line, here_.column});
  return code.size() - 1;
}

void Compiler::patch(std::size_t at) {
  function().code[at].a = static_cast<int>(function().code.size());
}

int Compiler::name_id(const std::string& name) {
  const auto [it, added] = ids_.try_emplace(name, static_cast<int>(program_.names.size()));
  if (added) {
    program_.names.push_back(name);
    assigned_.push_back(false);
  }
  return it->second;
}

int Compiler::constant(Value value) {
  program_.constants.push_back(std::move(value));
  return static_cast<int>(program_.constants.size()) - 1;
}

Function& Compiler::function() {
  return program_.functions[static_cast<std::size_t>(current_)];
}

void Compiler::expression() {
  const Depth depth(*this, peek());
  or_expression();
}

void Compiler::or_expression() {
  and_expression();
  while (is("or") || is("xor")) {
    if (accept("or")) {
      const auto jump = emit(Op::kJumpOr);
      and_expression();
      patch(jump);
    } else {
      next();
      and_expression();
      emit(Op::kBinary, static_cast<int>(Operator::kXor));
    }
  }
}

void Compiler::and_expression() {
  not_expression();
  while (accept("and")) {
    const auto jump = emit(Op::kJumpAnd);
    not_expression();
    patch(jump);
  }
}

void Compiler::not_expression() {
  int count = 0;
  while (accept("not")) ++count;
  comparison();
  for (; count > 0; --count) emit(Op::kNot);
}

void Compiler::comparison() {
  static constexpr std::array<Symbol, 6> kSymbols{{{"==", Operator::kEqual},
                                                   {"!=", Operator::kNotEqual},
                                                   {"<", Operator::kLess},
                                                   {">", Operator::kGreater},
                                                   {"<=", Operator::kLessEqual},
                                                   {">=", Operator::kGreaterEqual}}};
  sum();
  for (bool found = true; found;) {
    found = false;
    for (const auto& symbol : kSymbols)
      if (accept(symbol.text)) {
        sum();
        emit(Op::kBinary, static_cast<int>(symbol.op));
        found = true;
        break;
      }
  }
}

void Compiler::sum() {
  product();
  while (is("+") || is("-")) {
    const auto op = next().text == "+" ? Operator::kAdd : Operator::kSubtract;
    product();
    emit(Op::kBinary, static_cast<int>(op));
  }
}

void Compiler::product() {
  unary();
  while (is("*") || is("/") || is("%")) {
    const std::string text = next().text;
    unary();
    const auto op = text == "*" ? Operator::kMultiply : text == "/" ? Operator::kDivide : Operator::kModulo;
    emit(Op::kBinary, static_cast<int>(op));
  }
}

void Compiler::unary() {
  int minus = 0;
  for (; is("-") || is("+"); next())
    if (is("-")) ++minus;
  postfix();
  if (minus % 2 == 1) emit(Op::kNegate);
}

void Compiler::postfix() {
  primary();
  while (is("[") || is(".")) {
    if (accept(".")) {
      member_name();
      emit(Op::kIndex);
      continue;
    }
    next();
    expression();
    emit(Op::kIndex);
    while (accept(",")) {
      expression();
      emit(Op::kIndex);
    }
    expect("]");
  }
}

void Compiler::primary() {
  const Token token = next();
  if (token.kind == TokenKind::kInteger) {
    emit(Op::kConstant, constant(whole_number(token.number)));
  } else if (token.kind == TokenKind::kFloat) {
    emit(Op::kConstant, constant(token.number));
  } else if (token.kind == TokenKind::kString) {
    emit(Op::kConstant, constant(token.text));
  } else if (token.kind == TokenKind::kPose) {
    int count = 0;
    list("]", count);
    if (count != 6) fail(token);
    emit(Op::kMakePose);
  } else if (token.text == "[" && token.kind == TokenKind::kSymbol) {
    int count = 0;
    list("]", count);
    emit(Op::kMakeList, count);
  } else if (token.text == "(" && token.kind == TokenKind::kSymbol) {
    expression();
    expect(")");
  } else if (token.kind == TokenKind::kName && (token.text == "True" || token.text == "False")) {
    emit(Op::kConstant, constant(token.text == "True"));
  } else if (token.kind == TokenKind::kName && token.text == "run") {
    const Token name = next();
    if (!is_word(name)) fail(name);
    emit(Op::kRun, call(name));
  } else if (is_word(token) && is("(")) {
    const int site = call(token);
    here_ = token;
    emit(Op::kCall, site);
  } else if (is_word(token)) {
    const int id = name_id(token.text);
    loads_.emplace_back(id, token);
    emit(Op::kLoad, id);
  } else {
    fail(token);
  }
}

int Compiler::call(const Token& name) {
  CallSite site;
  site.name = name.text;
  site.function = current_;
  site.line = name.line;
  site.column = name.column;
  expect("(");
  while (!is(")")) {
    if (is_word(peek()) && is("=", 1)) {
      site.keywords.push_back(next().text);
      next();
    } else if (!site.keywords.empty()) {
      fail(peek());
    } else {
      ++site.positional;
    }
    expression();
    if (!accept(",") && !is(")")) fail(peek());
  }
  expect(")");
  program_.calls.push_back(std::move(site));
  return static_cast<int>(program_.calls.size()) - 1;
}

void Compiler::member_name() {
  const Token name = next();
  if (!is_word(name)) fail(name);
  emit(Op::kConstant, constant(name.text));
}

void Compiler::list(const char* close, int& count) {
  while (!is(close)) {
    expression();
    ++count;
    if (!accept(",") && !is(close)) fail(peek());
  }
  expect(close);
}

}  // namespace stonestack::urscript
