#pragma once
#include <cerrno>
#include <string>
#include <system_error>

namespace stonestack {

/// Text of an errno value.
[[nodiscard]] inline std::string system_text(int code) {
  return std::generic_category().message(code);
}

}  // namespace stonestack
