#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string>
#include <string_view>

#include "stonestack/core/rooms.hpp"

namespace stonestack::geometry {

/// Value of `bytes` (as many as T has) in the given byte order.
template <class T>
[[nodiscard]] T decoded(std::string_view bytes, std::endian order = std::endian::little) {
  std::array<char, sizeof(T)> copy;
  std::memcpy(copy.data(), bytes.data(), sizeof(T));
  if (order != std::endian::native) std::reverse(copy.begin(), copy.end());
  return std::bit_cast<T>(copy);
}

/// Appends a value, little-endian.
template <class T>
void append_little(std::string& bytes, T value) {
  auto copy = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if (std::endian::native != std::endian::little) std::reverse(copy.begin(), copy.end());
  bytes.append(copy.data(), copy.size());
}

}  // namespace stonestack::geometry
