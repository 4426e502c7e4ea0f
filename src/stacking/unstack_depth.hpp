#pragma once
#include <cstddef>
#include <vector>

#include "stonestack/core/rooms.hpp"

/// Private to stacking/: how many stones are unstacked so that the tower can go on otherwise.
namespace stonestack::stacking {

/// Returns how many stones to unstack; 0 if nothing promises more than the `standing` ones. `expected[k]`:
/// stones that are expected to stand in the end when the top k + 1 are unstacked first; 0 where no higher
/// tower was found. Each stone unstacked counts as 0.2 stones lost: it costs two motions, and may go wrong.
[[nodiscard]] std::size_t unstack_depth(const std::vector<double>& expected, std::size_t standing);

}  // namespace stonestack::stacking
