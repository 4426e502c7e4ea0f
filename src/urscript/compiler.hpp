#pragma once
#include <map>

#include "urscript/program.hpp"

namespace stonestack::urscript {

/// One pass from tokens to instructions. Names are resolved when everything is read, because a function may
/// call one that stands below it.
class Compiler {
 public:
  explicit Compiler(std::string_view source);
  [[nodiscard]] Program run(const BuiltinIndex& builtin_index);

 private:
  friend class Depth;
  struct Loop {
    std::size_t start = 0;
    std::vector<std::size_t> breaks;
  };

  // compile_statements.cpp
  void program();
  int definition();
  void parameters(Function& function);
  Value literal();
  void block();
  void statement();
  void word_statement(const Token& word);
  void if_statement();
  void while_statement();
  void assignment(Op store);
  void element_assignment();
  void resolve(const BuiltinIndex& builtin_index);
  [[nodiscard]] int find_function(const CallSite& call) const;
  void check_names() const;

  // compile_expressions.cpp
  void expression();
  void or_expression();
  void and_expression();
  void not_expression();
  void comparison();
  void sum();
  void product();
  void unary();
  void postfix();
  void primary();
  int call(const Token& name);
  void list(const char* close, int& count);
  void member_name();

  [[nodiscard]] const Token& peek(std::size_t ahead = 0) const;
  [[nodiscard]] bool is(const char* text, std::size_t ahead = 0) const;
  [[nodiscard]] bool is_word(const Token& token) const;
  const Token& next();
  bool accept(const char* text);
  void expect(const char* text);
  void end_of_statement();
  bool accept_new_line();
  [[noreturn]] void fail(const Token& token) const;
  std::size_t emit(Op op, int a = 0, int b = 0);
  void patch(std::size_t at);
  [[nodiscard]] int name_id(const std::string& name);
  [[nodiscard]] int constant(Value value);
  [[nodiscard]] Function& function();

  std::string_view source_;
  std::vector<Token> tokens_;
  std::size_t at_ = 0;
  int current_ = 0;  // function
  int depth_ = 0;
  Token here_;  // of the statement or call that instructions belong to
  Program program_;
  std::map<std::string, int> ids_;
  std::vector<bool> assigned_;  // by name id
  std::vector<std::pair<int, Token>> loads_;
  std::vector<Loop> loops_;
  std::map<std::pair<int, std::string>, int> visible_;  // last function of a name, by enclosing function
};

/// Counts nested constructs and refuses too many. (The message is composed only then: that means
/// to look for the line, which for every expression would make a long script take the square of its length.)
class Depth {
 public:
  Depth(Compiler& compiler, const Token& where);
  ~Depth() { --*depth_; }
  Depth(const Depth&) = delete;
  Depth& operator=(const Depth&) = delete;

 private:
  int* depth_;
};

}  // namespace stonestack::urscript
