#pragma once
#include <cstddef>
#include <vector>

#include "stonestack/core/rooms.hpp"

/// Private to stacking: how many stones are taken off to try another way.
namespace stonestack::stacking {

/// `expected[k]`: how many stones are expected to stand in the end when the top k + 1 of them are taken off
/// first; 0 where no higher tower was found. Each stone taken off counts as 0.2 stones lost: it costs two
/// motions, and may go wrong. Returns how many to take off; 0 if nothing promises more.
[[nodiscard]] std::size_t take_off_depth(const std::vector<double>& expected);

}  // namespace stonestack::stacking
