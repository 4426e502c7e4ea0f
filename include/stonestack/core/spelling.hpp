#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "stonestack/core/rooms.hpp"

#pragma GCC visibility push(default)

namespace stonestack::core {

/// Letters to insert, leave out or replace until `a` is `b` (Levenshtein).
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

/// The names that `name` may be a slip of, at most three: those that begin with it, then the nearest of those
/// at an edit distance of at most a third of its length (at least 1). May be none.
[[nodiscard]] std::vector<std::string> likely_meant(const std::vector<std::string>& names,
                                                    std::string_view name);

}  // namespace stonestack::core

#pragma GCC visibility pop
