#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "stonestack/core/rooms.hpp"

#pragma GCC visibility push(default)

namespace stonestack::core {

/// The `count` names nearest to `name` by edit distance (Levenshtein), nearest first; of equal ones in their
/// order.
[[nodiscard]] std::vector<std::string> nearest(const std::vector<std::string>& names, std::string_view name,
                                               std::size_t count);

/// The names that `name` may be a slip of: those that begin with it, then those at an edit distance of at
/// most a third of its length (at least 1); none is a sensible answer. At most three.
[[nodiscard]] std::vector<std::string> likely_meant(const std::vector<std::string>& names,
                                                    std::string_view name);

}  // namespace stonestack::core

#pragma GCC visibility pop
