#pragma once
#include <string>

#include "stonestack/detection/detect_stones.hpp"

#pragma GCC visibility push(default)

namespace stonestack::detection {

/// The options that a method stands for, to be changed further: default, or paper (section 2: RoPS, kd-tree,
/// one look, the inlier ratio). Throws InvalidArgument for any other.
[[nodiscard]] DetectionOptions options_of(const std::string& method);

}  // namespace stonestack::detection

#pragma GCC visibility pop
