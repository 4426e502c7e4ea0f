#pragma once
#include <string>
#include <string_view>

#include "stonestack/core/rooms.hpp"

namespace stonestack::geometry {

/// Expands LZF data (Lehmann's format, as in PCD files). Empty unless the result has exactly `expected` bytes
/// and every reference lies inside it; `expected` >= 1.
[[nodiscard]] std::string expand_lzf(std::string_view packed, std::size_t expected);

}  // namespace stonestack::geometry
