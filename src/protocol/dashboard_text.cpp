#include "protocol/dashboard_text.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>

namespace stonestack::protocol {
namespace {

constexpr std::size_t kLongestLine = 1024;

}  // namespace

std::optional<UrVersion> parse_polyscope_version(std::string_view line) {
  // Digits and dots that begin after a space (or the line's begin); three numbers at least.
  const std::size_t begin = line.find_first_of("0123456789");
  if (begin == std::string_view::npos || (begin > 0 && line[begin - 1] != ' ')) return std::nullopt;
  const char* at = line.data() + begin;
  const char* const end = line.data() + line.size();
  std::array<std::uint32_t, 4> parts{};
  std::size_t count = 0;
  while (count < parts.size()) {
    const auto [next, error] = std::from_chars(at, end, parts[count]);
    if (error != std::errc()) return std::nullopt;
    ++count;
    at = next;
    if (at == end || *at != '.') break;
    ++at;
  }
  if (count < 3 || (at != end && *at != ' ')) return std::nullopt;
  return UrVersion{parts[0], parts[1], parts[2], parts[3]};
}

std::optional<std::string> dashboard_value(std::string_view line, std::string_view label) {
  if (line.substr(0, label.size()) != label) return std::nullopt;
  line.remove_prefix(label.size());
  while (!line.empty() && line.front() == ' ') line.remove_prefix(1);
  while (!line.empty() && line.back() == ' ') line.remove_suffix(1);
  return std::string(line);
}

std::optional<bool> dashboard_truth(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (lower == "true") return true;
  if (lower == "false") return false;
  return std::nullopt;
}

bool is_dashboard_text(std::string_view line) {
  return line.size() <= kLongestLine &&
         std::all_of(line.begin(), line.end(), [](char c) { return (c >= 32 && c < 127) || c == '\t'; });
}

}  // namespace stonestack::protocol
