#pragma once
#include <string>

#include "protocol/big_endian.hpp"
#include "protocol/hex.hpp"

namespace stonestack::hardware {

/// A robot state with a part 10 that begins with `checksum` (hexadecimal): of as many bytes as a state of
/// URSim 5.8 has there, or fewer.
inline std::string state_with_safety(const std::string& checksum, std::size_t bytes = 38) {
  std::string data = hex(checksum);
  data.resize(bytes, '\x01');
  std::string part, state;
  put(part, static_cast<std::uint32_t>(data.size() + 5));
  part += hex("0A") + data;
  const std::string before = hex("00000009 08 00010001");
  put(state, static_cast<std::uint32_t>(before.size() + part.size() + 5));
  return state + hex("10") + before + part;
}

}  // namespace stonestack::hardware
