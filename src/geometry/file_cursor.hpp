#pragma once
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

#include "stonestack/core/error.hpp"

namespace stonestack::geometry {

/// Reads a file that lies in memory and never past its end. Every failure is a FileError that names the file
/// and, for text, the line.
class FileCursor {
 public:
  FileCursor(std::string path, std::string_view content) : path_(std::move(path)), rest_(content) {}

  [[nodiscard]] std::string_view rest() const { return rest_; }
  [[nodiscard]] std::size_t bytes_left() const { return rest_.size(); }
  [[nodiscard]] int line() const { return line_; }

  /// The next line without its end (LF or CRLF); lines count from 1.
  std::string_view next_line() {
    const std::size_t end = rest_.find('\n');
    std::string_view text = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    line_ = ++ends_;
    if (!text.empty() && text.back() == '\r') text.remove_suffix(1);
    return text;
  }

  /// The next word of the file, over line ends; empty at its end.
  std::string_view next_word() {
    std::size_t from = 0;
    while (from < rest_.size() && is_space(rest_[from])) ends_ += rest_[from++] == '\n' ? 1 : 0;
    line_ = ends_ + 1;
    std::size_t to = from;
    while (to < rest_.size() && !is_space(rest_[to])) ++to;
    const std::string_view word = rest_.substr(from, to - from);
    rest_.remove_prefix(to);
    return word;
  }

  /// The next `count` bytes.
  std::string_view next_bytes(std::size_t count) {
    if (count > rest_.size()) fail("ends too early", "the file is truncated; make it again");
    const std::string_view bytes = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return bytes;
  }

  /// A number in `word`, whole word, possibly not finite. Throws FileError.
  [[nodiscard]] double number(std::string_view word) const {
    if (word.empty()) fail("ends too early", "the file is truncated; make it again");
    std::string_view digits = word;
    if (digits.size() > 1 && digits.front() == '+') digits.remove_prefix(1);
    double value = 0.0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size())
      fail(concat("'", printable(word), "' is not a number"), "correct it");
    return value;
  }
  [[nodiscard]] double finite_number(std::string_view word) const {
    const double value = number(word);
    if (!std::isfinite(value)) fail(concat("'", printable(word), "' is not finite"), "correct it");
    return value;
  }

  [[noreturn]] void fail(const std::string& problem, const std::string& remedy) const {
    throw FileError(path_, line_ > 0 ? concat("line ", line_, ": ", problem) : problem, remedy);
  }
  /// Stops counting lines, for binary data.
  void leave_text() { line_ = 0; }

  /// At most 40 characters, other bytes as '?', for messages.
  [[nodiscard]] static std::string printable(std::string_view text) {
    std::string result(text.substr(0, 40));
    for (char& c : result)
      if (c < ' ' || c > '~') c = '?';
    return result;
  }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

  std::string path_;
  std::string_view rest_;
  int line_ = 0;  ///< of what was read last, from 1; 0: not text
  int ends_ = 0;  ///< line ends behind
};

/// The first word of `text`, which it takes away; empty when there is none.
inline std::string_view take_word(std::string_view& text) {
  const std::size_t from = text.find_first_not_of(" \t");
  if (from == std::string_view::npos) {
    text = {};
    return {};
  }
  std::size_t to = text.find_first_of(" \t", from);
  if (to == std::string_view::npos) to = text.size();
  const std::string_view word = text.substr(from, to - from);
  text.remove_prefix(to);
  return word;
}

}  // namespace stonestack::geometry
