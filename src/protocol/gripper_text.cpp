#include "protocol/gripper_text.hpp"

#include <algorithm>
#include <charconv>

#include "stonestack/core/error.hpp"

namespace stonestack::protocol {
namespace {

constexpr std::size_t kMaxWords = 32;
constexpr std::size_t kMinVariable = 3;  // letters, as in POS; SCN_BLOCK has more

std::string_view without_line_end(std::string_view text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.remove_suffix(1);
  return text;
}

/// Words with one space between them.
std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  while (words.size() <= kMaxWords) {
    const std::size_t space = text.find(' ');
    words.push_back(text.substr(0, space));
    if (space == std::string_view::npos) break;
    text.remove_prefix(space + 1);
  }
  return words;
}

bool is_variable(std::string_view word) {
  return word.size() >= kMinVariable &&
         std::all_of(word.begin(), word.end(), [](char c) { return (c >= 'A' && c <= 'Z') || c == '_'; });
}

std::optional<int> parse_byte(std::string_view word) {
  int value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (word.empty() || error != std::errc() || end != word.data() + word.size() || value < 0 || value > 255)
    return std::nullopt;
  return value;
}

}  // namespace

std::string set_text(const std::vector<GripperVariable>& variables) {
  std::string line = "SET";
  for (const auto& [name, value] : variables) line += core::concat(" ", name, " ", value);
  return line + "\n";
}

std::string get_text(const std::string& variable) {
  return "GET " + variable + "\n";
}

std::optional<GripperLine> parse_gripper_line(std::string_view line) {
  line = without_line_end(line);
  if (line.size() > kMaxGripperLine) return std::nullopt;
  const std::vector<std::string_view> words = words_of(line);
  GripperLine parsed;
  if (words.size() == 2 && words[0] == "GET" && is_variable(words[1])) {
    parsed.get = words[1];
    return parsed;
  }
  if (words.size() < 3 || words.size() > kMaxWords || words.size() % 2 == 0 || words[0] != "SET")
    return std::nullopt;
  for (std::size_t i = 1; i + 1 < words.size(); i += 2) {
    const std::optional<int> value = parse_byte(words[i + 1]);
    if (!is_variable(words[i]) || !value) return std::nullopt;
    parsed.set.emplace_back(words[i], *value);
  }
  return parsed;
}

bool is_gripper_ack(std::string_view answer) {
  return without_line_end(answer) == "ack";
}

std::optional<int> parse_gripper_answer(std::string_view answer, std::string_view variable) {
  const std::vector<std::string_view> words = words_of(without_line_end(answer));
  if (words.size() != 2 || words[0] != variable) return std::nullopt;
  return parse_byte(words[1]);
}

bool is_gripper_text(std::string_view answer) {
  answer = without_line_end(answer);
  return answer.size() <= kMaxGripperLine &&
         std::all_of(answer.begin(), answer.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

}  // namespace stonestack::protocol
