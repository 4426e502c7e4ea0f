#pragma once
#include <string>

#include "stonestack/stone/stone.hpp"

namespace stonestack::stone {

/// Is this a stone that could exist, with meshes that belong together? Throws FileError naming the file in
/// `folder` that is wrong, the value and the remedy.
void check_stone(const Stone& stone, const std::string& folder);

}  // namespace stonestack::stone
