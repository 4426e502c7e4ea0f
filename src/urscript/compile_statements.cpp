#include <algorithm>

#include "urscript/compiler.hpp"

namespace stonestack::urscript {
namespace {

constexpr std::size_t kLongestName = 256;  // characters of a name in an error

}  // namespace

Compiler::Compiler(std::string_view source) : source_(source), tokens_(cut(source)) {}

Program Compiler::run(const BuiltinIndex& builtin_index) {
  program();
  check_names();
  resolve(builtin_index);
  return std::move(program_);
}

void Compiler::program() {
  if (is("def") || is("sec") || is("thread")) {
    program_.secondary = is("sec");
    current_ = -1;
    program_.name = program_.functions[static_cast<std::size_t>(definition())].name;
  } else {
    program_.functions.emplace_back();
    while (peek().kind != TokenKind::kEnd) statement();
    emit(Op::kConstant, constant({}));
    emit(Op::kReturn);
  }
  while (accept_new_line()) continue;
  if (peek().kind != TokenKind::kEnd) fail(peek());
}

int Compiler::definition() {
  const Depth depth(*this, peek());
  const Token kind = next();
  const Token name = next();
  if (!is_word(name)) fail(name);
  const int index = static_cast<int>(program_.functions.size());
  Function made;
  made.name = name.text;
  made.parent = current_;
  made.thread = kind.text == "thread";
  made.line = kind.line;
  expect("(");
  parameters(made);
  expect(":");
  program_.functions.push_back(std::move(made));
  const int outer = current_;
  std::vector<Loop> outer_loops;
  std::swap(outer_loops, loops_);
  current_ = index;
  block();
  expect("end");
  emit(Op::kConstant, constant({}));
  emit(Op::kReturn);
  current_ = outer;
  std::swap(outer_loops, loops_);
  static_cast<void>(accept_new_line());
  return index;
}

void Compiler::parameters(Function& made) {
  bool preset = false;
  while (!is(")")) {
    const Token name = next();
    if (!is_word(name)) fail(name);
    Parameter parameter{name_id(name.text), std::nullopt};
    assigned_[static_cast<std::size_t>(parameter.name)] = true;
    if (accept("=")) {
      parameter.preset = literal();
      preset = true;
    } else if (preset) {
      fail(name);
    }
    made.parameters.push_back(std::move(parameter));
    if (!accept(",") && !is(")")) fail(peek());
  }
  expect(")");
}

Value Compiler::literal() {
  const bool minus = accept("-");
  const Token token = next();
  if (token.kind == TokenKind::kInteger) return whole_number(minus ? -token.number : token.number);
  if (token.kind == TokenKind::kFloat) return minus ? -token.number : token.number;
  if (minus) fail(token);
  if (token.kind == TokenKind::kString) return token.text;
  if (token.kind == TokenKind::kName && token.text == "True") return true;
  if (token.kind == TokenKind::kName && token.text == "False") return false;
  if (token.kind != TokenKind::kPose && token.text != "[") fail(token);
  List list;
  while (!is("]")) {
    const Depth depth(*this, token);
    list.push_back(literal());
    if (!accept(",") && !is("]")) fail(peek());
  }
  expect("]");
  if (token.kind != TokenKind::kPose) return list;
  if (list.size() != 6) fail(token);
  PoseVector pose;
  for (int i = 0; i < 6; ++i) {
    const Value& item = list[static_cast<std::size_t>(i)];
    if (!std::holds_alternative<double>(item.is) && !std::holds_alternative<long long>(item.is)) fail(token);
    pose[i] = number(item);
  }
  return pose;
}

void Compiler::block() {
  const Depth depth(*this, peek());
  while (!is("end") && !is("elif") && !is("else")) {
    if (peek().kind == TokenKind::kEnd) fail(peek());
    statement();
  }
}

void Compiler::statement() {
  const Token token = peek();
  here_ = token;
  if (accept_new_line()) return;
  if (is("def") || is("thread")) {
    definition();
  } else if (token.kind == TokenKind::kName && !is_word(token) && !is("run") && !is("not") && !is("True") &&
             !is("False")) {
    word_statement(token);
  } else if (is_word(token) && is("=", 1)) {
    assignment(Op::kStore);
  } else if (is_word(token) && (is("[", 1) || is(".", 1))) {
    element_assignment();
  } else {
    expression();
    emit(Op::kPop);
    end_of_statement();
  }
}

void Compiler::word_statement(const Token& word) {
  if (is("if")) return if_statement();
  if (is("while")) return while_statement();
  next();
  if (word.text == "global") return assignment(Op::kStoreGlobal);
  if (word.text == "local") return assignment(Op::kStoreLocal);
  if (word.text == "return") {
    if (peek().kind == TokenKind::kNewLine)
      emit(Op::kConstant, constant({}));
    else
      expression();
    emit(Op::kReturn);
  } else if (word.text == "kill" || word.text == "join") {
    expression();
    emit(word.text == "kill" ? Op::kKill : Op::kJoin);
    if (word.text == "join") emit(Op::kPop);
  } else if (word.text == "break" || word.text == "continue") {
    if (loops_.empty()) fail(word);
    if (word.text == "break")
      loops_.back().breaks.push_back(emit(Op::kJump));
    else
      emit(Op::kJump, static_cast<int>(loops_.back().start));
  } else if (word.text == "halt" || word.text == "enter_critical" || word.text == "exit_critical") {
    if (accept("(")) expect(")");
    emit(word.text == "halt"             ? Op::kHalt
         : word.text == "enter_critical" ? Op::kEnterCritical
                                         : Op::kExitCritical);
  } else if (word.text != "pass") {
    fail(word);
  }
  end_of_statement();
}

void Compiler::if_statement() {
  std::vector<std::size_t> ends;
  next();
  for (bool more = true; more;) {
    expression();
    expect(":");
    const auto skip = emit(Op::kJumpIfFalse);
    block();
    ends.push_back(emit(Op::kJump));
    patch(skip);
    here_ = peek();
    more = accept("elif");
  }
  if (accept("else")) {
    expect(":");
    block();
  }
  expect("end");
  for (const auto end : ends) patch(end);
  end_of_statement();
}

void Compiler::while_statement() {
  next();
  loops_.push_back({function().code.size(), {}});
  const Token head = here_;
  expression();
  expect(":");
  const auto skip = emit(Op::kJumpIfFalse);
  block();
  expect("end");
  here_ = head;
  emit(Op::kJump, static_cast<int>(loops_.back().start));
  patch(skip);
  for (const auto jump : loops_.back().breaks) patch(jump);
  loops_.pop_back();
  end_of_statement();
}

void Compiler::assignment(Op store) {
  const Token name = next();
  if (!is_word(name)) fail(name);
  const int id = name_id(name.text);
  if (is("=")) {
    next();
    expression();
  } else if (store != Op::kStore) {
    emit(Op::kConstant, constant({}));  // `local x` without a value
  } else {
    fail(peek());
  }
  assigned_[static_cast<std::size_t>(id)] = true;
  here_ = name;
  emit(store, id);
  end_of_statement();
}

// `name[i] = ...`, `name[i, j] = ...`, `name.member = ...`; `name[i]` alone is an expression.
void Compiler::element_assignment() {
  const std::size_t start = at_;
  const std::size_t code = function().code.size();
  const Token name = next();
  int count = 0;
  while (is("[") || is(".")) {
    if (accept(".")) {
      member_name();
      ++count;
      continue;
    }
    next();
    do {
      expression();
      ++count;
    } while (accept(","));
    expect("]");
  }
  if (!accept("=")) {
    function().code.resize(code);
    at_ = start;
    expression();
    emit(Op::kPop);
    return end_of_statement();
  }
  expression();
  const int id = name_id(name.text);
  loads_.emplace_back(id, name);
  here_ = name;
  emit(Op::kStoreElement, id, count);
  end_of_statement();
}

void Compiler::check_names() const {
  for (const auto& [id, token] : loads_)
    if (!assigned_[static_cast<std::size_t>(id)])
      throw CompileError{token.line, token.column,
                         "compile_error_name_not_found:" + token.text.substr(0, kLongestName) + ":"};
}

// The function of that name that is visible from the call: nearest enclosing definition first.
int Compiler::find_function(const CallSite& site) const {
  for (int scope = site.function;; scope = program_.functions[static_cast<std::size_t>(scope)].parent) {
    const auto it = visible_.find({scope, site.name});
    if (it != visible_.end()) return it->second;
    if (scope < 0) return -1;
  }
}

void Compiler::resolve(const BuiltinIndex& builtin_index) {
  for (std::size_t i = 0; i < program_.functions.size(); ++i)
    visible_[{program_.functions[i].parent, program_.functions[i].name}] = static_cast<int>(i);
  for (auto& site : program_.calls) {
    site.target = find_function(site);
    if (site.target < 0) site.builtin = builtin_index(site.name);
    if (site.target < 0 && site.builtin < 0)
      throw CompileError{site.line, site.column,
                         "compile_error_name_not_found:" + site.name.substr(0, kLongestName) + ":"};
  }
}

Program compile(std::string_view source, const BuiltinIndex& builtin_index) {
  return Compiler(source).run(builtin_index);
}

}  // namespace stonestack::urscript
