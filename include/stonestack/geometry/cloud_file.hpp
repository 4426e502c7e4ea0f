#pragma once
#include <string>

#include "stonestack/geometry/cloud.hpp"

#pragma GCC visibility push(default)

namespace stonestack::geometry {

/// Reads PLY and PCD (ASCII, binary, binary_compressed), organised or not. Throws FileError.
[[nodiscard]] Cloud read_cloud(const std::string& path);
/// PLY (binary little-endian) or PCD (binary) by extension; organised clouds keep width and height (PCD, and
/// PLY by comments "width N" and "height N").
void write_cloud(const std::string& path, const Cloud& cloud);

}  // namespace stonestack::geometry

#pragma GCC visibility pop
