#include "urscript/script_collector.hpp"

#include "urscript/lexer.hpp"

namespace stonestack::urscript {
namespace {

bool is_blank(std::string_view line) {
  const auto start = line.find_first_not_of(" \t\r");
  return start == std::string_view::npos || line[start] == '#';
}

}  // namespace

std::vector<std::string> ScriptCollector::feed(std::string_view bytes) {
  std::vector<std::string> whole;
  for (const char c : bytes) {
    if (c != '\n') {
      if (line_.size() <= kLongestScript) line_ += c;
      continue;
    }
    take_line(std::move(line_), whole);
    line_.clear();
  }
  return whole;
}

void ScriptCollector::take_line(std::string line, std::vector<std::string>& whole) {
  if (depth_ == 0) {
    if (is_blank(line)) return;
    if (!urscript::opens_program(line)) {
      whole.push_back(std::move(line));
      return;
    }
  }
  depth_ += urscript::block_balance(line);
  // What is longer than any program goes on to its end and is then refused whole: its last lines must not run
  // as programs of their own.
  if (program_.size() <= kLongestScript) program_ += line + "\n";
  if (depth_ > 0) return;
  depth_ = 0;
  whole.push_back(std::move(program_));
  program_.clear();
}

std::string ScriptCollector::give_up() {
  std::string rest = program_ + line_;
  program_.clear();
  line_.clear();
  depth_ = 0;
  return rest;
}

}  // namespace stonestack::urscript
