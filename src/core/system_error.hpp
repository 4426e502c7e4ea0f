#pragma once
#include <cerrno>
#include <string>
#include <system_error>

#include "stonestack/core/rooms.hpp"

namespace stonestack::core {

/// Text of an errno value.
[[nodiscard]] inline std::string system_text(int code) {
  return std::generic_category().message(code);
}

}  // namespace stonestack::core
