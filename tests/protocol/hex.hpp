#pragma once
#include <cctype>
#include <string>
#include <string_view>

#include "stonestack/core/rooms.hpp"

namespace stonestack::protocol {

/// Bytes spelled out: `hex("00 05 56 00 02")`. Text between single quotes stands for itself: `hex("02
/// 'Hi'")`.
inline std::string hex(std::string_view spelled) {
  std::string bytes;
  for (std::size_t i = 0; i < spelled.size(); ++i) {
    if (std::isspace(static_cast<unsigned char>(spelled[i])) != 0) continue;
    if (spelled[i] == '\'') {
      const std::size_t end = spelled.find('\'', i + 1);
      bytes += spelled.substr(i + 1, end - i - 1);
      i = end;
    } else {
      bytes.push_back(static_cast<char>(std::stoi(std::string(spelled.substr(i, 2)), nullptr, 16)));
      ++i;
    }
  }
  return bytes;
}

}  // namespace stonestack::protocol
