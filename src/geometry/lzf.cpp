#include "geometry/lzf.hpp"

namespace stonestack::geometry {

// A control byte below 32 announces that many literals + 1. Otherwise its upper three bits are a length - 2
// (7: one more byte is added) and its lower five, with the next byte, how far back to copy from, - 1.
std::string expand_lzf(std::string_view packed, std::size_t expected) {
  std::string result;
  result.reserve(expected);
  std::size_t at = 0;
  const auto next = [&] { return static_cast<std::size_t>(static_cast<unsigned char>(packed[at++])); };
  while (at < packed.size()) {
    const std::size_t control = next();
    if (control < 32) {
      const std::size_t count = control + 1;
      if (count > packed.size() - at || count > expected - result.size()) return {};
      result.append(packed.substr(at, count));
      at += count;
      continue;
    }
    std::size_t count = control >> 5U;
    if (packed.size() - at < (count == 7 ? 2U : 1U)) return {};
    if (count == 7) count += next();
    count += 2;
    const std::size_t back = ((control & 31U) << 8U) + next() + 1;
    if (back > result.size() || count > expected - result.size()) return {};
    for (std::size_t from = result.size() - back; count > 0; --count) result.push_back(result[from++]);
  }
  return result.size() == expected ? result : std::string();
}

}  // namespace stonestack::geometry
