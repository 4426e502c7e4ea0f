#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

#include "stonestack/core/error.hpp"
#include "stonestack/experiment/experiment.hpp"

namespace stonestack::experiment {
namespace {

/// A whole number of digits alone.
std::optional<int> whole_number(std::string_view text) {
  int value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc() || end != text.data() + text.size()) return {};
  return value;
}

}  // namespace

Shard parse_shard(const std::string& text) {
  const std::size_t slash = std::min(text.find('/'), text.size());
  const auto index = whole_number(std::string_view(text).substr(0, slash));
  const auto count = whole_number(std::string_view(text).substr(std::min(slash + 1, text.size())));
  require(index && count && *index >= 1 && *index <= *count,
          "--shard expects I/N with I from 1 to N, such as 2/8, got '", text, "'");
  return {*index, *count};
}

std::string to_text(const Shard& shard) {
  return concat(shard.index, '/', shard.count);
}

}  // namespace stonestack::experiment
