#pragma once
#include <string>

#include "stonestack/core/rooms.hpp"

/// Private to report/: a field of a CSV file.
namespace stonestack::report {

/// As it is, or quoted when it holds what would end it (RFC 4180).
[[nodiscard]] inline std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace stonestack::report
